//! Finds ranges of transformed inputs, for int8.

use super::forward::Transform;
use super::parts::{Scratch, Strip, Winograd};
use super::tile::{PLACES, REACH, SIDE};
use crate::cpu::conv::patch::{Source, Window};
use crate::cpu::conv::{Arithmetic, ConvShape};
use crate::plan::{Activation, Padding};
use bytemuck::cast_slice;
use fovol_simd::Simd;

/// Histograms of the magnitudes of transformed inputs.
#[derive(Debug, Clone, Default)]
pub struct Distances {
    /// Counts, \[place\]\[channel\]\[eighth of an octave\].
    counts: Vec<u32>,
}

/// Number of bins: eighths of octaves from 2⁻²⁰ on.
const EIGHTHS: usize = 8 * 26;
/// Number of low bits of an f32 that do not matter for its bin.
const BITS: u32 = 20;
/// Number of the first bin.
const FIRST: u32 = (127 - 20) << 3;
/// Number of ranges to try, in eighths of octaves below the largest observed value.
const TRIED: i32 = 32;
/// Smallest range, as a part of the largest range of all channels. Values that were never observed may still occur.
const LEAST: f32 = 1.0 / 128.0;

impl Distances {
    /// Whether nothing was observed yet.
    pub fn is_empty(&self) -> bool {
        self.counts.is_empty()
    }

    /// Ranges with the smallest squared error for each place and channel, \[place\]\[channel\].
    pub fn reach(&self, channels: usize) -> Vec<f32> {
        let of_place = |counts: &[u32]| {
            let reach: Vec<f32> = counts.chunks_exact(EIGHTHS).map(least_wrong).collect();
            let least = reach.iter().fold(1e-6, |most: f32, reach| most.max(*reach)) * LEAST;
            reach.into_iter().map(move |reach| rounded(reach.max(least)))
        };
        self.counts.chunks_exact(EIGHTHS * channels).flat_map(of_place).collect()
    }
}

/// Range for which the sum of squared errors is smallest.
fn least_wrong(counts: &[u32]) -> f32 {
    let there = counts.iter().enumerate().filter(|(_, count)| **count > 0);
    let middle = |eighth: usize| f32::from_bits((eighth as u32 + FIRST) << BITS | 1 << (BITS - 1));
    let seen: Vec<(f32, f32)> = there.map(|(eighth, &count)| (middle(eighth), count as f32)).collect();
    let most = seen.last().map_or(0.0, |(furthest, _)| *furthest);
    let error = |reach: f32| -> f64 {
        let step = reach / 127.0;
        let squared = |distance: f32| match distance {
            // Values below half a step are rounded to 0 and lost.
            distance if distance < 0.5 * step => distance * distance,
            distance if distance > reach => (distance - reach).powi(2),
            _ => step * step / 12.0,
        };
        seen.iter().map(|(distance, count)| f64::from(count * squared(*distance))).sum()
    };
    let tried = (0..TRIED).map(|eighths| most * (-0.125 * eighths as f32).exp2());
    tried.min_by(|a, b| error(*a).total_cmp(&error(*b))).unwrap_or(most)
}

/// Rounds to the three digits that files have.
fn rounded(number: f32) -> f32 {
    format!("{number:.2e}").parse().unwrap_or(number)
}

/// Transforms the concatenated `sources` and adds the magnitudes to `distances`.
pub fn note_transformed(sources: &[Source<'_>], padding: Padding, distances: &mut Distances) {
    let inputs = sources.iter().map(Source::channels).sum();
    let shape = ConvShape { inputs, outputs: 1, size: 3, stride: 1, padding, activation: Activation::None };
    let conv = Winograd::new(&shape, &vec![0.0; 9 * inputs], &[0.0], Simd::Portable, &Arithmetic::F32);
    distances.counts.resize(PLACES * inputs * EIGHTHS, 0);
    let [height, width] = sources[0].size();
    let (tiles, pixel) = (conv.strip_tiles(SIDE, width), conv.pixel());
    let mut scratch = Scratch::default();
    for (y, x) in
        (0..height).step_by(SIDE).flat_map(|y| (0..width).step_by(SIDE * tiles).map(move |x| (y, x)))
    {
        let strip = Strip { place: [y, x], row: 0, tiles };
        conv.load(
            sources,
            Window { y: y as isize - 1, x: x as isize - 1, rows: REACH, columns: SIDE * tiles + 2 },
            &mut scratch,
        );
        conv.simd.in_vectors(Transform { conv: &conv, sources, strip, scratch: &mut scratch });
        let transformed: &[f32] = cast_slice(&scratch.transformed);
        // Tiles beyond the border only complete groups and do not count.
        let inside = (width - x).div_ceil(SIDE);
        let places = distances.counts.chunks_exact_mut(inputs * EIGHTHS);
        for (counts, tiles) in places.zip(transformed.chunks_exact(tiles * pixel)) {
            for tile in tiles.chunks_exact(pixel).take(inside) {
                for (counts, v) in counts.chunks_exact_mut(EIGHTHS).zip(tile) {
                    let eighth = (v.abs().to_bits() >> BITS).saturating_sub(FIRST) as usize;
                    counts[eighth.min(EIGHTHS - 1)] += 1;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_large_numbers_are_cut_and_many_are_not() {
        let reach = |large: u32| {
            let mut counts = vec![0; EIGHTHS];
            // Many small values near 2⁻⁷ and some near 1.
            counts[8 * 13] = 1_000_000;
            counts[8 * 20] = large;
            least_wrong(&counts)
        };
        assert!(reach(100_000) > 0.9, "{}", reach(100_000));
        assert!(reach(1) < 0.9, "{}", reach(1));
    }
}
