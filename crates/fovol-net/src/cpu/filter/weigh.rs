use super::super::element::Element;
use super::super::floats::{Floats, MOST, VectorWork, four, transposed};
use super::super::map::{Stored, with_map};
use super::PreparedFilter;
use super::planes::{CHANNELS, Ring};
use crate::plan::{Normalisation, SQUARED_EPSILON, Taps};
use std::array::from_fn;

/// A number of each of some features side by side; as many as vectors have count.
type Lanes = [f32; MOST];

/// What is on its way for the features of a vector.
#[derive(Debug, Default)]
pub struct Chunk {
    /// \[feature\]\[channel\], and some numbers more.
    features: Vec<f32>,
    /// \[channel\].
    channels: Vec<Lanes>,
    /// \[output of the prediction\]: the weights of kernels and what is added.
    predicted: Vec<Lanes>,
}

/// The weights of a prediction, for so many outputs at a time as sums have room in registers.
#[derive(Debug, Clone)]
pub struct Prediction {
    /// \[block of outputs\]\[input\]\[output of the block\].
    weights: Vec<[f32; BLOCK]>,
    /// \[block of outputs\]\[output of the block\].
    bias: Vec<[f32; BLOCK]>,
    inputs: usize,
}

/// Outputs that are predicted at once.
const BLOCK: usize = 8;

impl Prediction {
    /// That of `weights` \[out, in\] and `bias` \[out\].
    pub fn new(weights: &[f32], bias: &[f32]) -> Self {
        let inputs = weights.len() / bias.len();
        let blocks = 0..bias.len().div_ceil(BLOCK);
        // 0 for outputs that the last block has too many.
        let of = |numbers: &[f32], at: usize| numbers.get(at).copied().unwrap_or(0.0);
        let row = |block: usize, input: usize| from_fn(|k| of(weights, (block * BLOCK + k) * inputs + input));
        Self {
            weights: blocks.clone().flat_map(|block| (0..inputs).map(move |i| row(block, i))).collect(),
            bias: blocks.map(|block| from_fn(|k| of(bias, block * BLOCK + k))).collect(),
            inputs,
        }
    }

    /// Makes `chunk` predict of the `count` features from number `first` on of row `y` of `map`.
    #[inline(always)]
    fn run<V: Floats>(&self, map: &Stored, [y, first, count]: [usize; 3], chunk: &mut Chunk, some: V) {
        let Chunk { features, channels, predicted } = chunk;
        let inputs = self.inputs;
        features.resize(MOST * inputs + 4, 0.0);
        with_map!(map, map => {
            let from = &map.row(y)[first * inputs..(first + count) * inputs];
            for (to, from) in features.iter_mut().zip(from) {
                *to = from.to_f32();
            }
        });
        channels.resize(inputs.next_multiple_of(4), [0.0; MOST]);
        for feature in (0..V::N).step_by(4) {
            transpose(&features[feature * inputs..], inputs, feature, channels);
        }
        predicted.resize(self.bias.len() * BLOCK, [0.0; MOST]);
        let blocks = predicted.as_chunks_mut::<BLOCK>().0.iter_mut().zip(&self.bias);
        for ((to, bias), weights) in blocks.zip(self.weights.chunks_exact(inputs)) {
            let mut sums = [some; BLOCK];
            for k in 0..BLOCK {
                sums[k] = some.splat(bias[k]);
            }
            for (channel, weights) in channels.iter().zip(weights) {
                let channel = some.load(channel);
                for k in 0..BLOCK {
                    sums[k] = channel.times_plus(some.splat(weights[k]), sums[k]);
                }
            }
            for k in 0..BLOCK {
                sums[k].store(&mut to[k]);
            }
        }
    }
}

/// Makes numbers `feature` and the three after it of all `channels` those of four features of `from`, which go on for some
/// numbers more.
#[inline(always)]
fn transpose(from: &[f32], inputs: usize, feature: usize, channels: &mut [Lanes]) {
    for (number, to) in channels.as_chunks_mut::<4>().0.iter_mut().enumerate() {
        let at = 4 * number;
        let columns = transposed([
            four(from, at),
            four(from, inputs + at),
            four(from, 2 * inputs + at),
            four(from, 3 * inputs + at),
        ]);
        for (to, column) in to.iter_mut().zip(columns) {
            column.write_to_slice(&mut to[feature..]);
        }
    }
}

/// The filtering of the rows that one row of features serves.
pub struct Weighing<'a> {
    pub filter: &'a PreparedFilter,
    /// The first of these rows.
    pub y: usize,
    /// Their pixels.
    pub width: usize,
    pub features: &'a Stored,
    pub images: &'a [Ring],
    pub chunk: &'a mut Chunk,
    pub out: &'a mut [f32],
}

impl VectorWork for Weighing<'_> {
    #[inline(always)]
    fn run<V: Floats>(self, some: V) {
        match self.filter.expand {
            1 => self.rows::<V, 1, { CHANNELS }>(some),
            _ => self.rows::<V, 2, { 2 * CHANNELS }>(some),
        }
    }
}

impl Weighing<'_> {
    /// `N`: numbers of the pixels of one row that a feature serves.
    #[inline(always)]
    fn rows<V: Floats, const EXPAND: usize, const N: usize>(self, some: V) {
        let features = self.width / EXPAND;
        let row = self.width * CHANNELS;
        for first in (0..features).step_by(V::N) {
            let place = [self.y / EXPAND, first, V::N.min(features - first)];
            self.filter.prediction.run(self.features, place, self.chunk, some);
            let weights = &mut self.chunk.predicted[..self.filter.weights];
            shape::<V, EXPAND>(self.filter.normalisation, weights, some);
            for line in 0..EXPAND {
                let pixels = self.pixels::<V, EXPAND, N>(line, first, some);
                join(&pixels, V::N, &mut self.out[line * row..][..row][first * N..]);
            }
        }
    }

    /// The pixels in row `line` of those that the features from `first` on serve, number by number.
    #[inline(always)]
    fn pixels<V: Floats, const EXPAND: usize, const N: usize>(
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
                // Columns from the one before the first pixel on, or from that.
                for column in 0..side + EXPAND - 1 {
                    let at = column + EXPAND - usize::from(side == 3);
                    let (phase, from) = (at % EXPAND, first + at / EXPAND);
                    let mut colour = [zero; CHANNELS];
                    for c in 0..CHANNELS {
                        colour[c] = some.load(&planes.of(c, phase)[from..]);
                    }
                    // For each pixel of a feature whose kernel looks there.
                    for pixel in 0..EXPAND {
                        if column < pixel || column - pixel >= side {
                            continue;
                        }
                        let number = tap + row * side + column - pixel;
                        let weight = some.load(&predicted[(number * EXPAND + line) * EXPAND + pixel]);
                        totals[pixel] = totals[pixel] + weight;
                        for c in 0..CHANNELS {
                            colours[pixel][c] = weight.times_plus(colour[c], colours[pixel][c]);
                        }
                    }
                }
            }
            tap += side * side;
        }
        let mut pixels = [[0.0; MOST]; N];
        for pixel in 0..EXPAND {
            for c in 0..CHANNELS {
                let mut mean = colours[pixel][c] / totals[pixel];
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

/// Turns predictions to weights, which are still to be divided by their sum.
#[inline(always)]
fn shape<V: Floats, const EXPAND: usize>(normalisation: Normalisation, predicted: &mut [Lanes], some: V) {
    if normalisation == Normalisation::Squared {
        for lanes in predicted {
            let weights = some.load(lanes);
            weights.times_plus(weights, some.splat(SQUARED_EPSILON)).store(lanes);
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

/// Writes number i of each of `planes`, side by side, to `row`, for the first `count` i or as far as that goes.
#[inline(always)]
fn join<const N: usize>(planes: &[Lanes; N], count: usize, row: &mut [f32]) {
    let cells = row.as_chunks_mut::<N>().0;
    for (number, cells) in cells.chunks_mut(4).take(count / 4).enumerate() {
        let at = 4 * number;
        let mut first = 0;
        while first < N {
            let zero = [0.0; MOST];
            let next = |k: usize| if first + k < N { &planes[first + k] } else { &zero };
            let numbers =
                transposed([four(next(0), at), four(next(1), at), four(next(2), at), four(next(3), at)]);
            let count = (N - first).min(4);
            for (cell, numbers) in cells.iter_mut().zip(&numbers) {
                cell[first..first + count].copy_from_slice(&numbers.to_array()[..count]);
            }
            first += 4;
        }
    }
}
