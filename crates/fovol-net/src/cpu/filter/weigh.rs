use super::super::element::Element;
use super::super::floats::{Floats, MOST, VectorWork, four, transposed};
use super::super::lines::{WORDS_OF_LINE, prefetch};
use super::super::map::{Map, Stored};
use super::PreparedFilter;
use super::planes::{CHANNELS, Ring};
use crate::plan::{Normalisation, SQUARED_EPSILON, Taps};
use bytemuck::{cast_slice, cast_slice_mut};
use std::array::from_fn;

/// A number of each of some features side by side; as many as vectors have count.
type Lanes = [f32; MOST];

/// What is on its way for the features of a vector.
#[derive(Debug, Default)]
pub struct Chunk {
    /// \[feature\]\[word of it\].
    features: Vec<u32>,
    /// \[channel\].
    channels: Vec<Lanes>,
    /// \[output of the prediction\]: the weights of kernels and what is added.
    predicted: Vec<Lanes>,
}

/// The weights of a prediction, for so many outputs at a time as sums have room in registers.
#[derive(Debug, Clone)]
pub struct Prediction {
    /// \[block of outputs\]\[input\]\[output of the block\].
    weights: Vec<f32>,
    /// \[block of outputs\]\[output of the block\].
    bias: Vec<f32>,
    inputs: usize,
    /// Outputs that are predicted at once: one of [`BLOCKS`].
    block: usize,
}

/// Outputs that may be predicted at once.
const BLOCKS: [usize; 3] = [8, 10, 13];

impl Prediction {
    /// That of `weights` \[out, in\] and `bias` \[out\].
    pub fn new(weights: &[f32], bias: &[f32]) -> Self {
        let (outputs, inputs) = (bias.len(), weights.len() / bias.len());
        let wasted = |block: &usize| outputs.next_multiple_of(*block);
        let block = BLOCKS.into_iter().min_by_key(wasted).unwrap_or(BLOCKS[0]);
        // 0 for outputs that the last block has too many.
        let of = |numbers: &[f32], at: usize| numbers.get(at).copied().unwrap_or(0.0);
        let whole = outputs.next_multiple_of(block);
        let order = (0..whole).step_by(block).flat_map(|first| {
            (0..inputs)
                .flat_map(move |input| (first..first + block).map(move |output| output * inputs + input))
        });
        Self {
            weights: order.map(|at| of(weights, at)).collect(),
            bias: (0..whole).map(|at| of(bias, at)).collect(),
            inputs,
            block,
        }
    }

    /// Makes `chunk` predict of the `count` features from number `first` on of row `y` of `map`.
    #[inline(always)]
    fn run<V: Floats>(&self, map: &Stored, place: [usize; 3], chunk: &mut Chunk, some: V) {
        let Chunk { features, channels, predicted } = chunk;
        match map {
            Stored::F32(map) => {
                let words = cast_slice(features_of(map, self.inputs, place));
                spread(words, self.inputs, features, channels, some, |words| [words]);
            }
            Stored::Bf16(map) if self.inputs.is_multiple_of(2) => {
                let words = cast_slice(features_of(map, self.inputs, place));
                spread(words, self.inputs / 2, features, channels, some, V::halves);
            }
            Stored::Bf16(map) => {
                let numbers: Vec<f32> =
                    features_of(map, self.inputs, place).iter().map(|v| v.to_f32()).collect();
                spread(cast_slice(&numbers), self.inputs, features, channels, some, |words| [words]);
            }
        }
        predicted.resize(self.bias.len(), [0.0; MOST]);
        match self.block {
            8 => self.sum::<V, 8>(channels, predicted, some),
            10 => self.sum::<V, 10>(channels, predicted, some),
            _ => self.sum::<V, 13>(channels, predicted, some),
        }
    }

    /// Makes `predicted` the sums over `channels`, `BLOCK` at a time.
    #[inline(always)]
    fn sum<V: Floats, const BLOCK: usize>(&self, channels: &[Lanes], predicted: &mut [Lanes], some: V) {
        let (weights, bias) = (self.weights.as_chunks::<BLOCK>().0, self.bias.as_chunks::<BLOCK>().0);
        let blocks = predicted.as_chunks_mut::<BLOCK>().0.iter_mut().zip(bias);
        for ((to, bias), weights) in blocks.zip(weights.chunks_exact(self.inputs)) {
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

/// The numbers of the `count` features from number `first` on of row `y` of `map`.
fn features_of<T: Element>(map: &Map<T>, inputs: usize, [y, first, count]: [usize; 3]) -> &[T] {
    &map.row(y)[first * inputs..(first + count) * inputs]
}

/// Makes `channels` of features whose `words` lie side by side, each of `pixel` words: in each word are as many
/// channels as `take` takes out of it.
#[inline(always)]
fn spread<V: Floats, const PARTS: usize>(
    words: &[u32],
    pixel: usize,
    memory: &mut Vec<u32>,
    channels: &mut Vec<Lanes>,
    some: V,
    take: impl Fn(V) -> [V; PARTS],
) {
    let whole = pixel.next_multiple_of(V::N);
    channels.resize(whole * PARTS, [0.0; MOST]);
    // In the order in which they lie, so that the processor knows what comes next.
    memory.resize(V::N * whole, 0);
    if pixel == whole {
        for (to, from) in memory.chunks_exact_mut(V::N).zip(words.chunks_exact(V::N)) {
            some.load(cast_slice(from)).store(cast_slice_mut(to));
        }
    } else {
        for (to, from) in memory.chunks_exact_mut(whole).zip(words.chunks_exact(pixel)) {
            to[..pixel].copy_from_slice(from);
        }
    }
    // The next ones, meanwhile.
    for line in (0..words.len()).step_by(WORDS_OF_LINE) {
        prefetch(words, words.len() + line);
    }
    for first in (0..whole).step_by(V::N) {
        let load = |feature: usize| some.load(cast_slice(&memory[feature * whole + first..][..V::N]));
        let mut vectors = [some; MOST];
        for feature in 0..V::N {
            vectors[feature] = load(feature);
        }
        transpose(&mut vectors);
        for number in 0..V::N {
            for (part, taken) in take(vectors[number]).into_iter().enumerate() {
                taken.store(&mut channels[(first + number) * PARTS + part]);
            }
        }
    }
}

/// Number i of each of the first vectors, as many as they have numbers, as vector i.
#[inline(always)]
fn transpose<V: Floats>(vectors: &mut [V; MOST]) {
    let mut pixels = *vectors;
    for first in (0..V::N).step_by(4) {
        let four = V::pixels_transposed(from_fn(|k| vectors[first + k]));
        pixels[first..first + 4].copy_from_slice(&four);
    }
    // Pixel p of vector i of group g is pixel g of vector i of group p now.
    for i in 0..4 {
        match V::N {
            16 => {
                let [a, b, c, d] = [pixels[i], pixels[4 + i], pixels[8 + i], pixels[12 + i]];
                let (even, odd) = ([a.evens(b), c.evens(d)], [a.odds(b), c.odds(d)]);
                vectors[i] = even[0].evens(even[1]);
                vectors[4 + i] = odd[0].evens(odd[1]);
                vectors[8 + i] = even[0].odds(even[1]);
                vectors[12 + i] = odd[0].odds(odd[1]);
            }
            8 => {
                let [a, b] = [pixels[i], pixels[4 + i]];
                (vectors[i], vectors[4 + i]) = (a.evens(b), a.odds(b));
            }
            _ => vectors[i] = pixels[i],
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
