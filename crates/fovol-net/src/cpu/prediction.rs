//! 1×1 convolutions with few outputs: as many features at once as vectors have numbers, so that no place in a vector is without
//! use. Numbers are f32 whatever they are stored as.

use super::element::Element;
use super::floats::{Floats, MOST};
use super::lines::{WORDS_OF_LINE, prefetch};
use super::rows::{Rows, View};
use bytemuck::{cast_slice, cast_slice_mut};
use std::array::from_fn;

/// A number of each of some features side by side; as many as vectors have count.
pub type Lanes = [f32; MOST];

/// What is on its way for the features of a vector.
#[derive(Debug, Default)]
pub struct Chunk {
    /// \[feature\]\[word of it\].
    features: Vec<u32>,
    /// \[channel\].
    channels: Vec<Lanes>,
    /// \[output of the prediction\]: the weights of kernels and what is added.
    pub predicted: Vec<Lanes>,
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
const BLOCKS: [usize; 4] = [13, 10, 8, 4];

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
    pub fn run<V: Floats>(&self, map: View<'_>, place: [usize; 3], chunk: &mut Chunk, some: V) {
        let Chunk { features, channels, predicted } = chunk;
        match map {
            View::F32(rows) => {
                let words = cast_slice(features_of(&rows, place));
                spread(words, self.inputs, features, channels, some, |words| [words]);
            }
            View::Bf16(rows) if self.inputs.is_multiple_of(2) => {
                let words = cast_slice(features_of(&rows, place));
                spread(words, self.inputs / 2, features, channels, some, V::halves);
            }
            View::Bf16(rows) => {
                let numbers: Vec<f32> = features_of(&rows, place).iter().map(|v| v.to_f32()).collect();
                spread(cast_slice(&numbers), self.inputs, features, channels, some, |words| [words]);
            }
        }
        predicted.resize(self.bias.len(), [0.0; MOST]);
        match self.block {
            4 => self.sum::<V, 4>(channels, predicted, some),
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

/// The numbers of the `count` features from number `first` on of row `y`.
#[inline(always)]
fn features_of<'a, T>(rows: &Rows<'a, T>, [y, first, count]: [usize; 3]) -> &'a [T] {
    let inputs = rows.size()[2];
    &rows.row(y)[first * inputs..(first + count) * inputs]
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
