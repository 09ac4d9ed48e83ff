//! Samples of a frame: bits, order, and the part of them that counts.

use super::pixel_format::{Kind, PixelFormat};

/// `count` bits from number `first` on as bytes of 0 and 1; the lowest bit of a byte comes first.
pub fn bits(packed: &[u8], first: usize, count: usize) -> Option<Vec<u8>> {
    let end = first.checked_add(count)?;
    if end.div_ceil(8) > packed.len() {
        return None;
    }
    Some((first..end).map(|bit| packed[bit / 8] >> (bit % 8) & 1).collect())
}

/// Samples in planes, one for each colour, side by side.
pub fn interleaved(planes: &[u8], samples: usize, size: usize) -> Vec<u8> {
    let plane = planes.len() / samples;
    let pixels = 0..plane / size;
    let at = |pixel: usize, sample: usize| sample * plane + pixel * size;
    pixels
        .flat_map(|pixel| (0..samples).map(move |sample| (pixel, sample)))
        .flat_map(|(pixel, sample)| planes[at(pixel, sample)..][..size].iter().copied())
        .collect()
}

/// Keeps the bits of little-endian `samples` that the format uses, at the lower end and with the sign carried on.
pub fn mask(samples: &mut [u8], format: &PixelFormat) {
    let Kind::Whole { is_signed } = format.kind else { return };
    if !format.is_padded() {
        return;
    }
    let size = format.sample_size();
    let down = format.high + 1 - format.stored;
    let up = 64 - format.stored;
    for sample in samples.chunks_exact_mut(size) {
        let mut word = [0; 8];
        word[..size].copy_from_slice(sample);
        let used = u64::from_le_bytes(word) >> down << up;
        let value = if is_signed { (used as i64 >> up) as u64 } else { used >> up };
        sample.copy_from_slice(&value.to_le_bytes()[..size]);
    }
}

#[cfg(test)]
mod tests {
    use super::super::pixel_format::Photometric;
    use super::*;

    #[test]
    fn unused_bits_are_taken_out_and_signs_carried_on() {
        let mut format = PixelFormat {
            size: [2, 1],
            samples: 1,
            is_planar: false,
            allocated: 16,
            stored: 12,
            high: 11,
            kind: Kind::Whole { is_signed: true },
            photometric: Photometric::Grey,
        };
        let mut samples = [0xFF, 0xFF, 0x05, 0xA0];
        mask(&mut samples, &format);
        assert_eq!(samples, [0xFF, 0xFF, 0x05, 0x00]);
        format = PixelFormat { high: 15, kind: Kind::Whole { is_signed: false }, ..format };
        let mut samples = [0xFF, 0xFF, 0x50, 0x80];
        mask(&mut samples, &format);
        assert_eq!(samples, [0xFF, 0x0F, 0x05, 0x08]);
    }

    #[test]
    fn bits_begin_anywhere() {
        assert_eq!(bits(&[0b1010_0000, 0b1], 5, 4), Some(vec![1, 0, 1, 1]));
        assert_eq!(bits(&[0], 5, 4), None);
    }

    #[test]
    fn planes_are_interleaved() {
        assert_eq!(interleaved(&[1, 2, 3, 4, 5, 6], 3, 1), [1, 3, 5, 2, 4, 6]);
    }
}
