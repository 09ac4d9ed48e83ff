//! Words of weights: as many numbers as a kernel multiplies at once.

use fovol_simd::Bf16;

/// An f32.
pub fn word_of_f32([one]: [f32; 1]) -> u32 {
    one.to_bits()
}

/// Two bf16, the first one in the low half.
pub fn word_of_bf16(pair: [f32; 2]) -> u32 {
    let [low, high] = pair.map(|value| u32::from(Bf16::from_f32(value).0));
    low | high << 16
}

/// Four signed bytes, the first one lowest. The numbers are integers −128…127.
pub fn word_of_bytes(four: [f32; 4]) -> u32 {
    u32::from_le_bytes(four.map(|value| value as i8 as u8))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_number_is_lowest() {
        assert_eq!(word_of_f32([1.0]), 0x3F80_0000);
        assert_eq!(word_of_bf16([1.0, -2.0]), 0xC000_3F80);
        assert_eq!(word_of_bytes([1.0, -1.0, 127.0, -128.0]), 0x807F_FF01);
    }
}
