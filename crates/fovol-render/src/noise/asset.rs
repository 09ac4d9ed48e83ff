//! Ranks in few bytes.

/// Packs ranks below 2²⁰, two into five bytes, little end first.
///
/// # Panics
/// When a rank is 2²⁰ or more.
pub fn encode_ranks(ranks: &[u32]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(ranks.len().div_ceil(2) * 5);
    for pair in ranks.chunks(2) {
        let [low, high] = [pair[0], pair.get(1).copied().unwrap_or(0)];
        assert!(low < 1 << 20 && high < 1 << 20, "only 20 bits of a rank are kept");
        let word = u64::from(low) | u64::from(high) << 20;
        bytes.extend_from_slice(&word.to_le_bytes()[..5]);
    }
    bytes
}

/// Reads `count` ranks that [`encode_ranks`] has packed; `None` where there are too few bytes.
pub fn decode_ranks(bytes: &[u8], count: usize) -> Option<Vec<u32>> {
    if bytes.len() < count.div_ceil(2) * 5 {
        return None;
    }
    let mut ranks = Vec::with_capacity(count + 1);
    for five in bytes.chunks_exact(5).take(count.div_ceil(2)) {
        let word = u64::from_le_bytes([five[0], five[1], five[2], five[3], five[4], 0, 0, 0]);
        ranks.push((word & 0xF_FFFF) as u32);
        ranks.push((word >> 20) as u32);
    }
    ranks.truncate(count);
    Some(ranks)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn packing_loses_nothing(ranks in prop::collection::vec(0u32..1 << 20, 0..50)) {
            prop_assert_eq!(decode_ranks(&encode_ranks(&ranks), ranks.len()), Some(ranks));
        }
    }
}
