//! 1×1 convolutions with few outputs. Each vector lane computes another pixel, so no lane is wasted; arithmetic is
//! f32 for all storage types.

use crate::cpu::tensor::rows::{Rows, View};
use bytemuck::{cast_slice, cast_slice_mut};
use fovol_simd::{MOST_LANES, SimdF32, WORDS_OF_LINE, prefetch};
use std::array::from_fn;

/// One value of each of several features, one per vector lane.
pub type Lanes = [f32; MOST_LANES];

/// Scratch memory for the features of one vector.
#[derive(Debug, Default)]
pub struct Chunk {
    /// Packed words, \[feature\]\[word\].
    features: Vec<u32>,
    /// Input channels, \[channel\]\[feature\].
    channels: Vec<Lanes>,
    /// Outputs of the prediction, \[output\]\[feature\]: kernel weights, then the addition.
    pub predicted: Vec<Lanes>,
}

/// Weights of a prediction, in blocks of as many outputs as have their sums in registers.
#[derive(Debug, Clone)]
pub struct Prediction {
    /// Weights, \[block of outputs\]\[input\]\[output of the block\].
    weights: Vec<f32>,
    /// Biases, \[block of outputs\]\[output of the block\].
    bias: Vec<f32>,
    inputs: usize,
    /// Number of outputs that are computed at once: one of [`BLOCKS`].
    block: usize,
}

/// TensorBuf of outputs that can be computed at once.
const BLOCKS: [usize; 4] = [13, 10, 8, 4];

impl Prediction {
    /// Prepares a prediction with `weights` \[out, in\] and `bias` \[out\].
    pub fn new(weights: &[f32], bias: &[f32]) -> Self {
        let (outputs, inputs) = (bias.len(), weights.len() / bias.len());
        let wasted = |block: &usize| outputs.next_multiple_of(*block);
        let block = BLOCKS.into_iter().min_by_key(wasted).unwrap_or(BLOCKS[0]);
        // Superfluous outputs of the last block have weights of 0.
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

    /// Predicts from `count` features of row `y` of `map`, from number `first` on. `place` is \[y, first, count\];
    /// the results are in `chunk.predicted`.
    #[inline(always)]
    pub fn run<V: SimdF32>(&self, map: View<'_>, place: [usize; 3], chunk: &mut Chunk, some: V) {
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
        predicted.resize(self.bias.len(), [0.0; MOST_LANES]);
        match self.block {
            4 => self.sum::<V, 4>(channels, predicted, some),
            8 => self.sum::<V, 8>(channels, predicted, some),
            10 => self.sum::<V, 10>(channels, predicted, some),
            _ => self.sum::<V, 13>(channels, predicted, some),
        }
    }

    /// Computes the sums over `channels`, for `BLOCK` outputs at a time.
    #[inline(always)]
    fn sum<V: SimdF32, const BLOCK: usize>(&self, channels: &[Lanes], predicted: &mut [Lanes], some: V) {
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
                    sums[k] = channel.mul_add(some.splat(weights[k]), sums[k]);
                }
            }
            for k in 0..BLOCK {
                sums[k].store(&mut to[k]);
            }
        }
    }
}

/// Returns the elements of `count` features from number `first` on of row `y`.
#[inline(always)]
fn features_of<'a, T>(rows: &Rows<'a, T>, [y, first, count]: [usize; 3]) -> &'a [T] {
    let inputs = rows.size()[2];
    &rows.row(y)[first * inputs..(first + count) * inputs]
}

/// Transposes features, whose `words` lie side by side with `pixel` words each, to `channels`. `take` unpacks the
/// channels of a word.
#[inline(always)]
fn spread<V: SimdF32, const PARTS: usize>(
    words: &[u32],
    pixel: usize,
    memory: &mut Vec<u32>,
    channels: &mut Vec<Lanes>,
    some: V,
    take: impl Fn(V) -> [V; PARTS],
) {
    let whole = pixel.next_multiple_of(V::N);
    channels.resize(whole * PARTS, [0.0; MOST_LANES]);
    // Memory is read in order, so that the processor's prefetcher can follow.
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
    // The next features are prefetched meanwhile.
    for line in (0..words.len()).step_by(WORDS_OF_LINE) {
        prefetch(words, words.len() + line);
    }
    for first in (0..whole).step_by(V::N) {
        let load = |feature: usize| some.load(cast_slice(&memory[feature * whole + first..][..V::N]));
        let mut vectors = [some; MOST_LANES];
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

/// Transposes the first vectors, as many as a vector has lanes: lane i of each vector becomes vector i.
#[inline(always)]
fn transpose<V: SimdF32>(vectors: &mut [V; MOST_LANES]) {
    let mut pixels = *vectors;
    for first in (0..V::N).step_by(4) {
        let four = V::pixels_transposed(from_fn(|k| vectors[first + k]));
        pixels[first..first + 4].copy_from_slice(&four);
    }
    // Now pixel p of vector i of group g is pixel g of vector i of group p.
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
