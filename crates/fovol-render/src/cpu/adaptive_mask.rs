use super::mask::{mask, packed};
use crate::Importance;
use crate::noise::{FrameNoise, Noise};
use crate::thresholds::WORD;
use fovol_core::{Fovea, FrameSize, Region, SampleMask};
use rayon::prelude::*;
use std::ops::Range;

/// Mask of frame `t` whose density away from the gaze follows `importance`, within `region`.
///
/// With the noise N and the fovea P_f of a pixel, it is sampled if N < (1 − b)·P_f + b, where b = λ·importance, at most 1.
/// λ is chosen so that the mask has as many samples as [`mask()`] has in the region. Outside it there are none.
pub fn adaptive_mask(
    fovea: &Fovea,
    size: FrameSize,
    noise: &Noise,
    t: u32,
    (importance, region): (&Importance, Region),
) -> SampleMask {
    let budget = count_within(&mask(fovea, size, noise, t), region);
    let keys = keys(fovea, size, &noise.frame(t), (importance, region));
    let limit = limit(&keys, budget, region.pixels());
    let mut mask = SampleMask::none(size);
    let words_per_row = mask.words_per_row();
    let words = words_of(region);
    let rows = mask.words_mut().par_chunks_exact_mut(words_per_row).skip(region.y as usize);
    rows.zip(keys.par_chunks_exact(words.len() * WORD)).for_each(|(row, keys)| {
        for (word, keys) in row[words.clone()].iter_mut().zip(keys.as_chunks::<WORD>().0) {
            *word = packed(|i| keys[i] < limit);
        }
    });
    mask
}

/// Words of a row of the mask that pixels of `region` lie in.
fn words_of(region: Region) -> Range<usize> {
    region.x as usize / WORD..((region.x + region.size.width) as usize).div_ceil(WORD)
}

/// Number of samples of `mask` in `region`.
fn count_within(mask: &SampleMask, region: Region) -> usize {
    let (first, end) = (region.x as usize, (region.x + region.size.width) as usize);
    let rows = region.y as usize..(region.y + region.size.height) as usize;
    let count = |row: &[u64]| -> usize {
        let bits = |word: usize| {
            let from = first.saturating_sub(64 * word).min(64);
            let to = end.saturating_sub(64 * word).min(64);
            let below = |bit: usize| if bit == 64 { u64::MAX } else { (1 << bit) - 1 };
            (row[word] & below(to) & !below(from)).count_ones() as usize
        };
        (first / 64..end.div_ceil(64)).map(bits).sum()
    };
    mask.words()[rows.start * mask.words_per_row()..rows.end * mask.words_per_row()]
        .chunks_exact(mask.words_per_row())
        .map(count)
        .sum()
}

/// The least λ with which each pixel is sampled: (N − P_f) / ((1 − P_f)·importance), 0 or more. Rows hold whole words of the
/// mask; keys of pixels outside `region` are infinite.
fn keys(
    fovea: &Fovea,
    size: FrameSize,
    noise: &FrameNoise<'_>,
    (importance, region): (&Importance, Region),
) -> Vec<f32> {
    let words = words_of(region);
    let (first, length) = (words.start * WORD, words.len() * WORD);
    let columns: Vec<f32> = (0..length).map(|i| fovea.falloff_x((first + i) as u32, size) as f32).collect();
    let inside = region.x as usize - first..(region.x + region.size.width) as usize - first;
    let scale = 1.0 / noise.levels() as f32;
    let mut keys = vec![0.0; region.size.height as usize * length];
    keys.par_chunks_exact_mut(length).enumerate().for_each_init(
        || vec![1.0; length],
        |inverse, (row, keys)| {
            let y = region.y + row as u32;
            let falloff = fovea.falloff_y(y, size) as f32;
            importance.put_inverse(y, first as u32, inverse);
            for (i, word) in words.clone().enumerate() {
                let part = i * WORD..(i + 1) * WORD;
                let (columns, inverse) = (&columns[part.clone()], &inverse[part.clone()]);
                put_keys(&noise.word(word, y), scale, (columns, falloff), inverse, &mut keys[part]);
            }
            keys[..inside.start].fill(f32::INFINITY);
            keys[inside.end..].fill(f32::INFINITY);
        },
    );
    keys
}

/// Writes the keys of a word of pixels, whose noise is `ranks` · `scale` and whose P_f is a column's times the row's.
#[inline(always)]
fn put_keys(
    ranks: &[u32; WORD],
    scale: f32,
    (columns, falloff): (&[f32], f32),
    inverse: &[f32],
    keys: &mut [f32],
) {
    for i in 0..WORD {
        let seen = columns[i] * falloff;
        let noise = (ranks[i] as f32 + 0.5) * scale;
        keys[i] = (noise - seen).max(0.0) * inverse[i] / (1.0 - seen).max(f32::MIN_POSITIVE);
    }
}

/// Exponent of the least key that is told apart from 0, and bins for each doubling.
const LEAST: i32 = -13;
const OCTAVES: usize = 20;
const BITS: u32 = 9;

/// Bin of `key`: keys of 2^[`LEAST`] and more in bins of equal ratio, smaller ones in the first.
#[inline]
fn bin(key: f32) -> usize {
    let first = ((LEAST + 127) as u32) << BITS;
    let at = (key.to_bits() >> (23 - BITS)).saturating_sub(first) as usize;
    at.min((OCTAVES << BITS) - 1)
}

/// Lower end of bin number `at`.
fn lower_end(at: usize) -> f32 {
    f32::from_bits((((LEAST + 127) as u32) << 23) + ((at as u32) << (23 - BITS)))
}

/// Limit below which about `budget` of the keys of `pixels` pixels lie: exact to a bin, whose ends differ by 0.2 %.
fn limit(keys: &[f32], budget: usize, pixels: usize) -> f32 {
    // λ is rarely more than the mean density, so most keys need not be counted.
    let likely = 4.0 * budget as f32 / pixels as f32;
    limit_below(keys, budget, likely)
        .unwrap_or_else(|| limit_below(keys, budget, f32::INFINITY).unwrap_or(f32::INFINITY))
}

/// [`limit`] of the keys below `most`; `None` if they are fewer than `budget`.
fn limit_below(keys: &[f32], budget: usize, most: f32) -> Option<f32> {
    let counts = keys
        .par_chunks(1 << 17)
        .map(|keys| {
            let mut counts = vec![0u32; OCTAVES << BITS];
            keys.iter().filter(|key| **key < most).for_each(|key| counts[bin(*key)] += 1);
            counts
        })
        .reduce_with(|mut all, counts| {
            all.iter_mut().zip(counts).for_each(|(all, count)| *all += count);
            all
        });
    let mut below = 0;
    for (at, count) in counts.unwrap_or_default().into_iter().enumerate() {
        let with = below + count as usize;
        if with >= budget {
            // The nearer end of the bin; its lower one leaves the bin out.
            let leaves_out = budget - below < with - budget;
            return Some(if leaves_out { lower_end(at) } else { lower_end(at + 1) });
        }
        below = with;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::NoiseKind;
    use proptest::prelude::*;

    const SIZE: FrameSize = FrameSize { width: 640, height: 360 };

    fn region() -> Region {
        Region { x: 37, y: 20, size: FrameSize { width: 501, height: 300 } }
    }

    /// Importance that rises from left to right.
    fn rising() -> Importance {
        let [columns, rows] = Importance::cells_of(region());
        Importance::new(region(), (0..columns * rows).map(|i| (i % columns) as f32).collect())
    }

    #[test]
    fn masks_have_the_samples_of_fixed_ones_and_follow_importance() {
        for (base, sigma) in [(0.03, 0.02), (0.07, 0.06), (0.01, 0.0), (0.5, 0.1)] {
            let fovea = Fovea { base, sigma, gaze: [0.5, 0.4] };
            for kind in NoiseKind::ALL {
                let noise = Noise::new(kind, 1);
                for t in 0..4 {
                    let expected = count_within(&mask(&fovea, SIZE, &noise, t), region());
                    let found = adaptive_mask(&fovea, SIZE, &noise, t, (&rising(), region()));
                    assert_eq!(count_within(&found, region()), found.count());
                    // Blue noise has few ranks, each at many pixels.
                    let off = found.count().abs_diff(expected);
                    assert!(off <= 6 + expected / 400, "{kind} {base} {sigma}: {expected} {}", found.count());
                    let half = |x: u32| {
                        let half = Region { x, size: FrameSize { width: 150, height: 300 }, ..region() };
                        count_within(&found, half)
                    };
                    let [left, right] = [half(37), half(388)];
                    assert!(base > 0.1 || right > 2 * left, "{kind} {base} {sigma}: {left} {right}");
                }
            }
        }
    }

    #[test]
    fn an_even_importance_is_the_fixed_mask() {
        let (fovea, noise) = (Fovea::default(), Noise::new(NoiseKind::Stbn, 0));
        let [columns, rows] = Importance::cells_of(region());
        let even = Importance::new(region(), vec![1.0; columns * rows]);
        let found = adaptive_mask(&fovea, SIZE, &noise, 3, (&even, region()));
        let fixed = mask(&fovea, SIZE, &noise, 3);
        let differ = (0..SIZE.height).flat_map(|y| (0..SIZE.width).map(move |x| (x, y))).filter(|(x, y)| {
            let is_inside = (37..538).contains(x) && (20..320).contains(y);
            found.contains(*x, *y) != (is_inside && fixed.contains(*x, *y))
        });
        assert!(differ.count() * 300 < found.count());
    }

    proptest! {
        #[test]
        fn any_budget_is_met(base in 0.0f64..=1.0, sigma in 0.0f64..0.3, seed in 0u64..20) {
            let fovea = Fovea { base, sigma, gaze: [0.3, 0.6] };
            let noise = Noise::new(NoiseKind::Uniform, seed);
            let expected = count_within(&mask(&fovea, SIZE, &noise, 0), region());
            let found = adaptive_mask(&fovea, SIZE, &noise, 0, (&rising(), region())).count();
            let off = (found as f64 - expected as f64).abs();
            prop_assert!(off <= 3.0 + 0.003 * expected as f64, "{expected} {found}");
        }
    }
}
