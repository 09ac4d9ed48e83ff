use crate::noise::{FrameNoise, Noise};
use crate::thresholds::{Thresholds, WORD, limit};
use fovol_core::{Fovea, FrameSize, SampleMask};
use rayon::prelude::*;

/// Whether pixel (`x`, `y`) of frame `t` is sampled: N = (rank + ½)/levels < τ.
///
/// This is the specification; [`mask()`] finds the same bits for a whole frame.
pub fn sampled(fovea: &Fovea, size: FrameSize, noise: &Noise, t: u32, [x, y]: [u32; 2]) -> bool {
    let frame = noise.frame(t);
    (f64::from(frame.rank(x, y)) + 0.5) / f64::from(frame.levels()) < fovea.density_at(x, y, size)
}

/// The pixels of frame `t` that are sampled: those whose noise N lies below τ.
pub fn mask(fovea: &Fovea, size: FrameSize, noise: &Noise, t: u32) -> SampleMask {
    let frame = noise.frame(t);
    let thresholds = Thresholds::new(fovea, size, frame.levels());
    let mut mask = SampleMask::none(size);
    let words_per_row = mask.words_per_row();
    mask.words_mut().par_chunks_mut(words_per_row * ROWS).enumerate().for_each(|(task, rows)| {
        for (row, words) in rows.chunks_mut(words_per_row).enumerate() {
            let y = (task * ROWS + row) as u32;
            mask_row(&frame, y, &thresholds, fovea.falloff_y(y, size), words);
        }
    });
    mask
}

/// Rows that one task makes.
const ROWS: usize = 32;
/// The bits of row `y`, whose factor of the fovea is `falloff`.
fn mask_row(noise: &FrameNoise<'_>, y: u32, thresholds: &Thresholds, falloff: f64, words: &mut [u64]) {
    let base_limit = limit(thresholds.base);
    // Words outside the fovea repeat as the noise does.
    let mut plain = [None; 2];
    for (i, word) in words.iter_mut().enumerate() {
        // The limit rises with the threshold: if the word's densest column does not raise it, none does.
        let outside = limit(thresholds.base + thresholds.widest[i] * falloff) == base_limit;
        *word = match noise.words_per_tile() {
            Some(period) if outside => {
                *plain[i % period].get_or_insert_with(|| plain_word(&noise.word(i, y), base_limit))
            }
            None if outside => plain_word(&noise.word(i, y), base_limit),
            _ => fovea_word(&noise.word(i, y), thresholds.base, &thresholds.columns[i], falloff),
        };
    }
    if let Some(last) = words.last_mut() {
        *last &= thresholds.last_word;
    }
}

/// rank < `limit`.
fn plain_word(ranks: &[u32; WORD], limit: u32) -> u64 {
    packed(|i| ranks[i] < limit)
}

/// rank + ½ < `base` + `columns`·`falloff`.
fn fovea_word(ranks: &[u32; WORD], base: f64, columns: &[f64; WORD], falloff: f64) -> u64 {
    packed(|i| f64::from(ranks[i]) + 0.5 < base + columns[i] * falloff)
}

/// The word whose bit i is `bit(i)`.
#[inline(always)]
pub fn packed(bit: impl Fn(usize) -> bool) -> u64 {
    // First bytes, which compile to vector instructions; then eight bytes to eight bits by one product.
    let flags: [u8; WORD] = std::array::from_fn(|i| u8::from(bit(i)));
    let (eights, _) = flags.as_chunks::<8>();
    eights.iter().enumerate().fold(0, |word, (i, &eight)| {
        let bits = u64::from_le_bytes(eight).wrapping_mul(0x0102_0408_1020_4080) >> 56;
        word | bits << (8 * i)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::NoiseKind;
    use proptest::prelude::*;

    #[test]
    fn densities_are_those_of_the_paper_over_64_frames() {
        let size = FrameSize::default();
        for (base, sigma, expected) in [(0.03, 0.02, 0.0343), (0.07, 0.06, 0.1074)] {
            let fovea = Fovea { base, sigma, gaze: [0.5, 0.5] };
            for kind in NoiseKind::ALL {
                let noise = Noise::new(kind, 1);
                let drawn: f64 = (0..64).map(|t| mask(&fovea, size, &noise, t).density()).sum::<f64>() / 64.0;
                assert!((drawn / expected - 1.0).abs() < 0.02, "{kind} ({base}, {sigma}): {drawn}");
            }
        }
    }

    #[test]
    fn nothing_and_everything_can_be_asked_for() {
        let size = FrameSize::new(70, 20).unwrap();
        let noise = Noise::new(NoiseKind::Stbn, 0);
        let fovea = |base| Fovea { base, sigma: 0.0, gaze: [0.5, 0.5] };
        assert_eq!(mask(&fovea(0.0), size, &noise, 0).count(), 0);
        assert_eq!(mask(&fovea(1.0), size, &noise, 0), SampleMask::full(size));
    }

    #[test]
    fn the_mask_does_not_depend_on_the_number_of_threads() {
        let (fovea, size, noise) = (Fovea::default(), FrameSize::default(), Noise::new(NoiseKind::Blue, 2));
        let with = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| mask(&fovea, size, &noise, 9))
        };
        assert_eq!(with(1), with(5));
    }

    #[test]
    fn thresholds_that_meet_a_rank_exactly_are_decided_alike() {
        let size = FrameSize::new(128, 128).unwrap();
        let noise = Noise::new(NoiseKind::Blue, 0);
        for halves in [1, 2, 3, 1000, 1001, 32_767] {
            // (rank + ½)/levels = τ is not below τ; a fovea far away must not tip it over.
            let base = f64::from(halves) / 2.0 / f64::from(noise.frame(0).levels());
            for sigma in [0.0, 0.05, 0.1, 0.2] {
                let fovea = Fovea { base, sigma, gaze: [-0.1, 0.5] };
                let slow = SampleMask::from_fn(size, |x, y| sampled(&fovea, size, &noise, 0, [x, y]));
                assert_eq!(mask(&fovea, size, &noise, 0), slow, "{halves} {sigma}");
            }
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(40))]
        #[test]
        fn rows_follow_the_specification(
            w in 1u32..200, h in 1u32..60, base in 0.0f64..1.0, sigma in 0.0f64..0.3,
            gx in -0.2f64..1.2, gy in 0.0f64..1.0, t in 0u32..200, kind in 0usize..3,
        ) {
            let size = FrameSize::new(w, h).unwrap();
            let fovea = Fovea { base, sigma, gaze: [gx, gy] };
            let noise = Noise::new(NoiseKind::ALL[kind], 3);
            let fast = mask(&fovea, size, &noise, t);
            let slow = SampleMask::from_fn(size, |x, y| sampled(&fovea, size, &noise, t, [x, y]));
            prop_assert_eq!(fast, slow);
        }
    }
}
