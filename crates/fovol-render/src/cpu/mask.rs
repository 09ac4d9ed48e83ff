use crate::noise::Noise;
use fovol_core::{Fovea, FrameSize, SampleMask};
use rayon::prelude::*;

/// The pixels of frame `t` that are sampled: those whose noise N lies below τ.
///
/// The specification is [`sampled`] at every pixel; this is the same, by rows.
pub fn mask(fovea: &Fovea, size: FrameSize, noise: &Noise, t: u32) -> SampleMask {
    let frame = noise.frame(t);
    let levels = f64::from(frame.levels());
    let columns: Vec<f64> =
        (0..size.width).map(|x| (1.0 - fovea.base) * fovea.falloff_x(x, size) * levels).collect();
    let widest = columns.iter().copied().fold(0.0, f64::max);
    let mut mask = SampleMask::none(size);
    let words_per_row = mask.words_per_row();
    let width = size.width as usize;
    mask.words_mut().par_chunks_mut(words_per_row * ROWS).enumerate().for_each_init(
        || vec![0u32; width],
        |ranks, (chunk, rows)| {
            for (row, words) in rows.chunks_mut(words_per_row).enumerate() {
                let y = (chunk * ROWS + row) as u32;
                frame.row(y, ranks);
                let falloff = fovea.falloff_y(y, size);
                let base = fovea.base * levels - 0.5;
                if falloff * widest < NEGLIGIBLE {
                    threshold_row(ranks, base, words);
                } else {
                    fovea_row(ranks, &columns, falloff, base, words);
                }
            }
        },
    );
    mask
}

/// Whether pixel (`x`, `y`) of frame `t` is sampled: (rank + ½)/levels < τ.
pub fn sampled(fovea: &Fovea, size: FrameSize, noise: &Noise, t: u32, [x, y]: [u32; 2]) -> bool {
    let frame = noise.frame(t);
    (f64::from(frame.rank(x, y)) + 0.5) / f64::from(frame.levels()) < fovea.density_at(x, y, size)
}

/// Rows that one task makes.
const ROWS: usize = 32;
/// A fovea that moves thresholds by less than this many levels cannot change a comparison of whole ranks
/// other than by rounding.
const NEGLIGIBLE: f64 = 1e-9;

/// rank < `threshold`, the same for the whole row.
fn threshold_row(ranks: &[u32], threshold: f64, words: &mut [u64]) {
    // The smallest whole number that is not below the threshold; the cast saturates.
    let limit = threshold.ceil() as u32;
    for (ranks, word) in ranks.chunks(64).zip(words) {
        *word = ranks.iter().enumerate().fold(0, |bits, (i, &rank)| bits | u64::from(rank < limit) << i);
    }
}

/// rank < `base` + `columns`·`falloff`.
fn fovea_row(ranks: &[u32], columns: &[f64], falloff: f64, base: f64, words: &mut [u64]) {
    for ((ranks, columns), word) in ranks.chunks(64).zip(columns.chunks(64)).zip(words) {
        let both = ranks.iter().zip(columns).enumerate();
        *word = both.fold(0, |bits, (i, (&rank, column))| {
            bits | u64::from(f64::from(rank) < base + column * falloff) << i
        });
    }
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
