//! Bytes, or bits, of equal place in their values lie together: puts them back.

/// Writes the values whose shuffled bytes are `shuffled` to `out`, of the same length. What does not fill a value
/// stands at the end as it is.
pub fn unshuffle(shuffled: &[u8], out: &mut [u8], size: usize) {
    match size {
        1 => out.copy_from_slice(shuffled),
        2 => unshuffle_fixed::<2>(shuffled, out),
        4 => unshuffle_fixed::<4>(shuffled, out),
        8 => unshuffle_fixed::<8>(shuffled, out),
        _ => unshuffle_any(shuffled, out, size),
    }
}

fn unshuffle_fixed<const N: usize>(shuffled: &[u8], out: &mut [u8]) {
    let count = shuffled.len() / N;
    let planes: [&[u8]; N] = std::array::from_fn(|place| &shuffled[place * count..][..count]);
    let (values, rest) = out.as_chunks_mut::<N>();
    for (at, value) in values.iter_mut().enumerate().take(count) {
        *value = std::array::from_fn(|place| planes[place][at]);
    }
    rest.copy_from_slice(&shuffled[count * N..]);
}

fn unshuffle_any(shuffled: &[u8], out: &mut [u8], size: usize) {
    let count = shuffled.len() / size;
    let whole = count * size;
    for (place, plane) in shuffled[..whole].chunks_exact(count.max(1)).enumerate() {
        for (value, &byte) in out[..whole].chunks_exact_mut(size).zip(plane) {
            value[place] = byte;
        }
    }
    out[whole..].copy_from_slice(&shuffled[whole..]);
}

/// Writes the values whose shuffled bits are `shuffled` to `out`, of the same length. Bits are shuffled only where the
/// number of values is a multiple of 8.
pub fn unshuffle_bits(shuffled: &[u8], out: &mut [u8], size: usize) {
    let count = shuffled.len() / size;
    if !count.is_multiple_of(8) || count == 0 {
        out.copy_from_slice(shuffled);
        return;
    }
    let (whole, row) = (count * size, count / 8);
    // Row 8·i + j holds bit j of byte i of all values.
    for (place, rows) in shuffled[..whole].chunks_exact(count).enumerate() {
        for eight in 0..row {
            let bits = u64::from_le_bytes(std::array::from_fn(|bit| rows[bit * row + eight]));
            let bytes = transposed(bits).to_le_bytes();
            for (value, byte) in bytes.into_iter().enumerate() {
                out[(8 * eight + value) * size + place] = byte;
            }
        }
    }
    out[whole..].copy_from_slice(&shuffled[whole..]);
}

/// The transpose of 8 × 8 bits: row i is byte i. From Hacker's Delight, section 7-3.
fn transposed(mut bits: u64) -> u64 {
    for (shift, mask) in
        [(7, 0x00AA_00AA_00AA_00AA), (14, 0x0000_CCCC_0000_CCCC), (28, 0x0000_0000_F0F0_F0F0)]
    {
        let swapped = (bits ^ (bits >> shift)) & mask;
        bits ^= swapped ^ (swapped << shift);
    }
    bits
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_come_back() {
        for size in [1, 2, 3, 4, 8, 13] {
            let values: Vec<u8> = (0..101).collect();
            let count = values.len() / size;
            let mut shuffled = values.clone();
            for (at, &byte) in values[..count * size].iter().enumerate() {
                shuffled[at % size * count + at / size] = byte;
            }
            let mut out = vec![0; values.len()];
            unshuffle(&shuffled, &mut out, size);
            assert_eq!(out, values, "{size}");
        }
    }

    #[test]
    fn bits_are_transposed() {
        let bits = 0x8040_2010_0804_0201;
        assert_eq!(transposed(bits), bits);
        assert_eq!(transposed(0xFF), 0x0101_0101_0101_0101);
    }
}
