use crate::noise::{hash, unit};
use fovol_core::{Fovea, FrameSize, Pixel, SampleList, SampleMask};

/// Positions drawn from the density instead of being decided pixel by pixel.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DirectSamples {
    /// round(C·w·h) positions in raster order; some may be equal.
    pub list: SampleList,
    /// How many of them repeat a position: marched for nothing.
    pub lost: usize,
}

/// Draws round(C·w·h) positions of frame `t` from the density τ: a mixture of the uniform base and the
/// separable fovea, so each draw inverts two one-dimensional distributions.
pub fn direct(fovea: &Fovea, size: FrameSize, seed: u64, t: u32) -> DirectSamples {
    let density = fovea.expected_density(size);
    let count = (density * size.pixels() as f64).round() as usize;
    let columns = cumulative((0..size.width).map(|x| fovea.falloff_x(x, size)));
    let rows = cumulative((0..size.height).map(|y| fovea.falloff_y(y, size)));
    let from_base = if density > 0.0 { fovea.base / density } else { 1.0 };
    let seed = hash(seed ^ 0xD1EC7, u64::from(t));
    let mut pixels: Vec<Pixel> = (0..count as u64)
        .map(|i| {
            let [which, u, v] = [0, 1, 2].map(|j| unit(seed, 3 * i + j));
            let (x, y) = if which < from_base {
                ((u * f64::from(size.width)) as usize, (v * f64::from(size.height)) as usize)
            } else {
                (drawn(&columns, u), drawn(&rows, v))
            };
            Pixel { x: x as u16, y: y as u16 }
        })
        .collect();
    pixels.sort_unstable_by_key(|p| (p.y, p.x));
    let lost = pixels.windows(2).filter(|pair| pair[0] == pair[1]).count();
    DirectSamples { list: SampleList::new(size, pixels), lost }
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
