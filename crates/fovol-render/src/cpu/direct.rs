use crate::noise::{hash, unit};
use fovol_core::{Fovea, FrameSize, Pixel, SampleList, SampleMask};
use rayon::prelude::*;

/// Positions drawn from the density instead of being decided pixel by pixel.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DirectSamples {
    /// round(C·w·h) positions in raster order; some may be equal.
    pub list: SampleList,
    /// How many of them repeat a position: marched for nothing.
    pub lost: usize,
}

/// Draws round(C·w·h) positions of frame `t` from the density τ; `seed` and `t` choose which.
pub fn direct(fovea: &Fovea, size: FrameSize, seed: u64, t: u32) -> DirectSamples {
    let density = fovea.expected_density(size);
    let count = (density * size.pixels() as f64).round() as u64;
    let distribution = Distribution::new(fovea, size, density);
    let seed = hash(seed ^ 0xD1EC7, u64::from(t));
    let mut pixels: Vec<Pixel> = (0..count)
        .into_par_iter()
        .map(|i| distribution.at([0, 1, 2].map(|j| unit(seed, 3 * i + j))))
        .collect();
    // Equal positions cannot be told apart, so the order does not depend on the threads.
    pixels.par_sort_unstable_by_key(|p| u32::from(p.y) << 16 | u32::from(p.x));
    let lost = pixels.windows(2).filter(|pair| pair[0] == pair[1]).count();
    DirectSamples { list: SampleList::new(size, pixels), lost }
}

/// τ/Σ τ: a mixture of the uniform base and the separable fovea, so each draw inverts two one-dimensional
/// distributions.
struct Distribution {
    size: FrameSize,
    /// The share of draws that belong to the base.
    from_base: f64,
    columns: Vec<f64>,
    rows: Vec<f64>,
}

impl Distribution {
    fn new(fovea: &Fovea, size: FrameSize, density: f64) -> Self {
        Self {
            size,
            from_base: if density > 0.0 { fovea.base / density } else { 1.0 },
            columns: cumulative((0..size.width).map(|x| fovea.falloff_x(x, size))),
            rows: cumulative((0..size.height).map(|y| fovea.falloff_y(y, size))),
        }
    }

    /// The position that three numbers in [0, 1) fall to.
    fn at(&self, [which, u, v]: [f64; 3]) -> Pixel {
        let (x, y) = if which < self.from_base {
            ((u * f64::from(self.size.width)) as usize, (v * f64::from(self.size.height)) as usize)
        } else {
            (drawn(&self.columns, u), drawn(&self.rows, v))
        };
        Pixel { x: x as u16, y: y as u16 }
    }
}

/// The mask of the positions in `list`.
pub fn mask_of(list: &SampleList) -> SampleMask {
    let mut mask = SampleMask::none(list.size());
    for p in list.pixels() {
        mask.set(p.x.into(), p.y.into());
    }
    mask
}

fn cumulative(weights: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut sum = 0.0;
    weights
        .map(|w| {
            sum += w;
            sum
        })
        .collect()
}

/// The position that `u` in [0, 1) falls to.
fn drawn(cumulative: &[f64], u: f64) -> usize {
    let target = u * cumulative[cumulative.len() - 1];
    cumulative.partition_point(|&c| c <= target).min(cumulative.len() - 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_number_is_exact_and_the_losses_are_counted() {
        let size = FrameSize::default();
        let fovea = Fovea { base: 0.07, sigma: 0.06, gaze: [0.4, 0.6] };
        let samples = direct(&fovea, size, 1, 0);
        let expected = (fovea.expected_density(size) * size.pixels() as f64).round() as usize;
        assert_eq!(samples.list.len(), expected);
        assert_eq!(mask_of(&samples.list).count(), expected - samples.lost);
        assert!(samples.lost > expected / 20, "a dense fovea draws many positions twice: {}", samples.lost);
        assert_ne!(samples, direct(&fovea, size, 1, 1));
    }

    #[test]
    fn the_draw_does_not_depend_on_the_number_of_threads() {
        let (fovea, size) = (Fovea::default(), FrameSize::default());
        let with = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| direct(&fovea, size, 3, 9))
        };
        assert_eq!(with(1), with(5));
    }

    #[test]
    fn nothing_is_drawn_from_a_density_of_zero() {
        let size = FrameSize::new(20, 10).unwrap();
        let nowhere = Fovea { base: 0.0, sigma: 0.001, gaze: [9.0, 9.0] };
        assert!(direct(&nowhere, size, 0, 0).list.is_empty());
    }

    #[test]
    fn positions_follow_the_density() {
        let size = FrameSize::new(64, 32).unwrap();
        let fovea = Fovea { base: 0.02, sigma: 0.1, gaze: [0.3, 0.5] };
        let mut hits = vec![0u32; size.pixels()];
        let frames = 4000;
        for t in 0..frames {
            for p in direct(&fovea, size, 7, t).list.pixels() {
                hits[p.index(size.width)] += 1;
            }
        }
        // Compared over 8×8 blocks: expected hits are in the hundreds there.
        for by in 0..4 {
            for bx in 0..8 {
                let block = (0..8).flat_map(|y| (0..8).map(move |x| (bx * 8 + x, by * 8 + y)));
                let (mut found, mut wanted) = (0.0, 0.0);
                for (x, y) in block {
                    found += f64::from(hits[(y * 64 + x) as usize]);
                    wanted += fovea.density_at(x, y, size) * f64::from(frames);
                }
                assert!(
                    (found - wanted).abs() < 5.0 * wanted.sqrt() + 0.01 * wanted,
                    "block {bx},{by}: {found} {wanted}"
                );
            }
        }
    }
}
