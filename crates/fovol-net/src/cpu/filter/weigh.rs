use super::planes::{CHANNELS, Ring};
use super::prepared::PreparedFilter;
use crate::cpu::conv::prediction::{Chunk, Lanes};
use crate::cpu::tensor::AnyTensor;
use crate::cpu::tensor::vec4::four;
use crate::plan::{Normalisation, SQUARED_EPSILON, Taps};
use fovol_simd::{MOST_LANES, Pixels, SimdF32, SimdF32Op};
use glam::Vec4;

/// Operation that filters the rows that one row of features serves.
pub struct Weighing<'a> {
    pub filter: &'a PreparedFilter,
    /// First of these rows.
    pub y: usize,
    /// Pixels of a row.
    pub width: usize,
    pub features: &'a AnyTensor,
    pub images: &'a [Ring],
    pub chunk: &'a mut Chunk,
    pub out: &'a mut [f32],
}

impl SimdF32Op for Weighing<'_> {
    type Output = ();

    #[inline(always)]
    fn run<V: SimdF32>(self, some: V) {
        match self.filter.expand {
            1 => self.rows::<V, 1, { CHANNELS }>(some),
            _ => self.rows::<V, 2, { 2 * CHANNELS }>(some),
        }
    }
}

impl Weighing<'_> {
    /// Filters rows. `N` is the number of values that one feature serves in a row.
    #[inline(always)]
    fn rows<V: SimdF32, const EXPAND: usize, const N: usize>(self, some: V) {
        let features = self.width / EXPAND;
        let row = self.width * CHANNELS;
        for first in (0..features).step_by(V::N) {
            let place = [self.y / EXPAND, first, V::N.min(features - first)];
            self.filter.prediction.run(self.features.into(), place, self.chunk, some);
            let weights = &mut self.chunk.predicted[..self.filter.weights];
            shape::<V, EXPAND>(self.filter.normalisation, weights, some);
            for line in 0..EXPAND {
                let pixels = self.pixels::<V, EXPAND, N>(line, first, some);
                join(&pixels, V::N, &mut self.out[line * row..][..row][first * N..]);
            }
        }
    }

    /// Filters the pixels in row `line` of those that the features from `first` on serve. Results are in planes,
    /// one for each value.
    #[inline(always)]
    fn pixels<V: SimdF32, const EXPAND: usize, const N: usize>(
        &self,
        line: usize,
        first: usize,
        some: V,
    ) -> [Lanes; N] {
        let Self { filter, y, images, chunk, .. } = self;
        let predicted = &chunk.predicted[..];
        let zero = some.splat(0.0);
        let (mut colours, mut totals) = ([[zero; CHANNELS]; EXPAND], [zero; EXPAND]);
        let mut tap = 0;
        for (image, &taps) in images.iter().zip(&filter.taps) {
            let side = if taps == Taps::Around { 3 } else { 1 };
            for row in 0..side {
                let planes = image.row(y + line + row + usize::from(side == 1));
                // Columns from the one before the first pixel on, or from the first pixel on.
                for column in 0..side + EXPAND - 1 {
                    let at = column + EXPAND - usize::from(side == 3);
                    let (phase, from) = (at % EXPAND, first + at / EXPAND);
                    let mut colour = [zero; CHANNELS];
                    for c in 0..CHANNELS {
                        colour[c] = some.load(&planes.of(c, phase)[from..]);
                    }
                    // Adds to every pixel of the feature whose window contains this column.
                    for pixel in 0..EXPAND {
                        if column < pixel || column - pixel >= side {
                            continue;
                        }
                        let number = tap + row * side + column - pixel;
                        let weight = some.load(&predicted[(number * EXPAND + line) * EXPAND + pixel]);
                        totals[pixel] = totals[pixel] + weight;
                        for c in 0..CHANNELS {
                            colours[pixel][c] = weight.mul_add(colour[c], colours[pixel][c]);
                        }
                    }
                }
            }
            tap += side * side;
        }
        let mut pixels = [[0.0; MOST_LANES]; N];
        for pixel in 0..EXPAND {
            let share = totals[pixel].recip();
            for c in 0..CHANNELS {
                let mut mean = colours[pixel][c] * share;
                if filter.has_addition {
                    let number = filter.weights + (c * EXPAND + line) * EXPAND + pixel;
                    mean = mean + some.load(&predicted[number]);
                }
                mean.store(&mut pixels[pixel * CHANNELS + c]);
            }
        }
        pixels
    }
}

/// Turns predictions into positive weights, which are still to be divided by their sum.
#[inline(always)]
fn shape<V: SimdF32, const EXPAND: usize>(normalisation: Normalisation, predicted: &mut [Lanes], some: V) {
    if normalisation == Normalisation::Squared {
        for lanes in predicted {
            let weights = some.load(lanes);
            weights.mul_add(weights, some.splat(SQUARED_EPSILON)).store(lanes);
        }
        return;
    }
    let pixels = EXPAND * EXPAND;
    for pixel in 0..pixels {
        let mut most = some.splat(f32::NEG_INFINITY);
        for lanes in predicted[pixel..].iter().step_by(pixels) {
            most = most.max(some.load(lanes));
        }
        for lanes in predicted[pixel..].iter_mut().step_by(pixels) {
            (some.load(lanes) - most).store(lanes);
            lanes.iter_mut().for_each(|weight| *weight = weight.exp());
        }
    }
}

/// Interleaves `planes`: value i of each plane goes to `row`, for the first `count` values or as many as fit.
#[inline(always)]
fn join<const N: usize>(planes: &[Lanes; N], count: usize, row: &mut [f32]) {
    let cells = row.as_chunks_mut::<N>().0;
    for (number, cells) in cells.chunks_mut(4).take(count / 4).enumerate() {
        let at = 4 * number;
        let mut first = 0;
        while first < N {
            let zero = [0.0; MOST_LANES];
            let next = |k: usize| if first + k < N { &planes[first + k] } else { &zero };
            let numbers = Vec4::pixels_transposed([
                four(next(0), at),
                four(next(1), at),
                four(next(2), at),
                four(next(3), at),
            ]);
            let count = (N - first).min(4);
            for (cell, numbers) in cells.iter_mut().zip(&numbers) {
                cell[first..first + count].copy_from_slice(&numbers.to_array()[..count]);
            }
            first += 4;
        }
    }
}
