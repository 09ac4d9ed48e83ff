use super::{Arithmetic, ConvShape, Kernel};
use crate::cpu::element::{Bf16, Element};
use crate::cpu::simd::Simd;

/// The numbers that the largest block gives.
pub const LARGEST_BLOCK: usize = 16 * 32;

/// Weights in the order of their use: blocks of output channels.
#[derive(Debug, Clone)]
pub struct Packed {
    blocks: Vec<Block>,
}

/// Some of the output channels.
#[derive(Debug, Clone)]
pub struct Block {
    /// The first of them.
    pub first: usize,
    /// How many there are, with zeros after the last channel.
    pub width: usize,
    /// \[row of the window\]\[column\]\[word of a pixel\]\[channel of the block\].
    pub weights: Vec<u32>,
    /// A number for each channel of the block.
    pub bias: Vec<f32>,
    /// What sums of bytes are worth, for each channel of the block.
    worth: Option<Vec<f32>>,
    /// What computes it.
    pub kernel: Kernel,
}

impl Block {
    /// Turns sums of bytes to values; other sums are values already.
    #[inline(always)]
    pub fn scale(&self, sums: &mut [f32]) {
        if let Some(worth) = &self.worth {
            for ((sum, &worth), &bias) in sums.iter_mut().zip(worth).zip(&self.bias) {
                *sum = *sum * worth + bias;
            }
        }
    }
}

impl Packed {
    /// `weights` \[out, in, size, size\] and `bias` \[out\] for the kernels of `simd`.
    pub fn new(
        shape: &ConvShape,
        weights: &[f32],
        bias: &[f32],
        simd: Simd,
        arithmetic: &Arithmetic,
    ) -> Self {
        let mut blocks = Vec::new();
        let mut first = 0;
        while first < shape.outputs {
            let (width, kernel) = simd.block(shape.outputs - first, arithmetic);
            let channels = first..(first + width).min(shape.outputs);
            let (weights, worth) = match arithmetic {
                Arithmetic::Int8 { steps } => {
                    let (bytes, worth) = quantised(shape, weights, channels, steps);
                    (
                        words(shape, &bytes, width, 4, |four| {
                            u32::from_le_bytes(std::array::from_fn(|i| four[i] as i8 as u8))
                        }),
                        Some(worth),
                    )
                }
                Arithmetic::Bf16 => {
                    let part = &weights[rows(shape, channels)];
                    (
                        words(shape, part, width, 2, |pair| {
                            u32::from(Bf16::from_f32(pair[0]).0) | u32::from(Bf16::from_f32(pair[1]).0) << 16
                        }),
                        None,
                    )
                }
                Arithmetic::F32 => {
                    let part = &weights[rows(shape, channels)];
                    (words(shape, part, width, 1, |one| one[0].to_bits()), None)
                }
            };
            let bias = (first..first + width).map(|c| bias.get(c).copied().unwrap_or(0.0)).collect();
            blocks.push(Block { first, width, weights, bias, worth, kernel });
            first += width;
        }
        Self { blocks }
    }

    /// All of them.
    pub fn blocks(&self) -> &[Block] {
        &self.blocks
    }
}

/// Where the weights of output `channels` lie.
fn rows(shape: &ConvShape, channels: std::ops::Range<usize>) -> std::ops::Range<usize> {
    let row = shape.inputs * shape.size * shape.size;
    channels.start * row..channels.end * row
}

/// The weights of output `channels` times the steps of their inputs as whole numbers −127…127, and what one of
/// them is worth in each channel.
fn quantised(
    shape: &ConvShape,
    weights: &[f32],
    channels: std::ops::Range<usize>,
    steps: &[f32],
) -> (Vec<f32>, Vec<f32>) {
    let (area, row) = (shape.size * shape.size, shape.inputs * shape.size * shape.size);
    let mut bytes = Vec::new();
    let mut worth = Vec::new();
    for weights in weights[rows(shape, channels)].chunks_exact(row) {
        let scaled: Vec<f32> = weights.iter().enumerate().map(|(i, w)| w * steps[i / area]).collect();
        let most = scaled.iter().fold(0.0f32, |most, w| most.max(w.abs()));
        let one = if most > 0.0 { most / 127.0 } else { 1.0 };
        bytes.extend(scaled.iter().map(|w| (w / one).round()));
        worth.push(one);
    }
    (bytes, worth)
}

/// `weights` \[channel of the block, in, size, size\] in the order of their use: `count` inputs to a word, with
/// zeros for channels and inputs that do not exist.
fn words(
    shape: &ConvShape,
    weights: &[f32],
    width: usize,
    count: usize,
    pack: impl Fn(&[f32]) -> u32,
) -> Vec<u32> {
    let (n, inputs) = (shape.size, shape.inputs);
    let mut out = Vec::with_capacity(n * n * inputs.div_ceil(count) * width);
    let mut group = vec![0.0; count];
    for place in 0..n * n {
        for first in (0..inputs).step_by(count) {
            for channel in 0..width {
                for (i, number) in group.iter_mut().enumerate() {
                    let at = (channel * inputs + first + i) * n * n + place;
                    let exists = first + i < inputs;
                    *number = if exists { weights.get(at).copied().unwrap_or(0.0) } else { 0.0 };
                }
                out.push(pack(&group));
            }
        }
    }
    out
}
