use fovol_core::{Pixel, SampleList, SampleMask};
use rayon::prelude::*;

/// Rows that one task packs.
const ROWS: usize = 32;

/// Stream compaction: the sampled pixels of `mask` in raster order.
pub fn compact(mask: &SampleMask) -> SampleList {
    let words_per_row = mask.words_per_row();
    let parts: Vec<&[u64]> = mask.words().chunks(words_per_row * ROWS).collect();
    let counts: Vec<usize> =
        parts.par_iter().map(|words| words.iter().map(|w| w.count_ones() as usize).sum()).collect();
    let mut pixels = vec![Pixel { x: 0, y: 0 }; counts.iter().sum()];
    // Every task writes the part of the list that the counts before it leave free.
    let mut rest = pixels.as_mut_slice();
    let mut targets = Vec::with_capacity(parts.len());
    for &count in &counts {
        let (target, after) = rest.split_at_mut(count);
        targets.push(target);
        rest = after;
    }
    parts.into_par_iter().zip(targets).enumerate().for_each(|(part, (words, target))| {
        let mut at = 0;
        for (i, &word) in words.iter().enumerate() {
            let y = (part * ROWS + i / words_per_row) as u16;
            let left = (i % words_per_row * 64) as u16;
            let mut bits = word;
            while bits != 0 {
                target[at] = Pixel { x: left + bits.trailing_zeros() as u16, y };
                at += 1;
                bits &= bits - 1;
            }
        }
    });
    SampleList::new(mask.size(), pixels)
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovol_core::FrameSize;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_list_is_the_mask_in_raster_order(w in 1u32..200, h in 1u32..100, seed in 0u64..100, density in 0u64..=100) {
            let size = FrameSize::new(w, h).unwrap();
            let mask = SampleMask::from_fn(size, |x, y| crate::noise::hash(seed, u64::from(y * 1000 + x)) % 100 < density);
            let list = compact(&mask);
            let expected: Vec<Pixel> = (0..h).flat_map(|y| (0..w).map(move |x| (x, y)))
                .filter(|&(x, y)| mask.contains(x, y))
                .map(|(x, y)| Pixel { x: x as u16, y: y as u16 }).collect();
            prop_assert_eq!(list.pixels(), expected);
        }
    }
}
