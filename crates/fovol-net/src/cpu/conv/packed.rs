use super::call::Kernel;
use super::finish::Worth;
use super::kernels::{self, OutputBlock};
use super::shape::{Arithmetic, ConvShape};
use super::words::{word_of_bf16, word_of_bytes, word_of_f32};
use fovol_simd::{AlignedBuf, Simd};

/// Number of elements of the largest block: pixels × channels.
pub const LARGEST_BLOCK: usize = 32 * 32;

/// Weights packed for kernels, in blocks of output channels.
#[derive(Debug, Clone)]
pub struct Packed {
    blocks: Vec<Block>,
}

/// Weights of some output channels.
#[derive(Debug, Clone)]
pub struct Block {
    /// First output channel.
    pub first: usize,
    /// Number of channels, including padding after the last one, whose weights are 0.
    pub width: usize,
    /// Weights, \[row of the window\]\[column\]\[word of a pixel\]\[channel of the block\]. Zeros pad each row to
    /// the length that kernels multiply at once.
    pub weights: AlignedBuf,
    /// Bias of each channel of the block.
    pub bias: Vec<f32>,
    /// Dequantisation of int8 sums; `None` for other arithmetic, whose sums are values already.
    pub worth: Option<Worth>,
    /// Kernel that computes the block.
    pub kernel: Kernel,
}

impl Packed {
    /// Packs `weights` \[out, in, size, size\] and `bias` \[out\] for the kernels of `simd`.
    pub fn new(
        shape: &ConvShape,
        weights: &[f32],
        bias: &[f32],
        simd: Simd,
        arithmetic: &Arithmetic,
    ) -> Self {
        let packed = |OutputBlock { first, width, channels, bias, kernel }: OutputBlock| {
            let order = Order { shape, width, run: kernels::run(simd, arithmetic) };
            let (weights, worth) = match arithmetic {
                Arithmetic::Int8 { steps, .. } => {
                    let (bytes, mut factors) = quantised(shape, weights, channels, steps);
                    factors.resize(width, 0.0);
                    (order.words(&bytes, word_of_bytes), Some(Worth { factors, bias: bias.clone() }))
                }
                Arithmetic::Bf16 | Arithmetic::SplitBf16 => {
                    (order.words(&weights[rows(shape, channels)], word_of_bf16), None)
                }
                Arithmetic::F32 => (order.words(&weights[rows(shape, channels)], word_of_f32), None),
            };
            Block { first, width, weights: weights.into(), bias, worth, kernel }
        };
        let blocks = kernels::output_blocks(simd, arithmetic, bias).into_iter().map(packed).collect();
        Self { blocks }
    }

    /// All blocks.
    pub fn blocks(&self) -> &[Block] {
        &self.blocks
    }
}

/// Range of the weights of output `channels`.
fn rows(shape: &ConvShape, channels: std::ops::Range<usize>) -> std::ops::Range<usize> {
    let row = shape.inputs * shape.size * shape.size;
    channels.start * row..channels.end * row
}

/// Quantises the weights of output `channels`: weights times the steps of their inputs as integers −127…127. Also
/// returns the step of each channel.
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

/// Order of a block's weights.
struct Order<'a> {
    shape: &'a ConvShape,
    /// Channels of the block.
    width: usize,
    /// Words of a window's row that are multiplied at once.
    run: usize,
}

impl Order<'_> {
    /// Packs `weights` \[channel of the block, in, size, size\] in this order, `COUNT` inputs to a word, with zeros for
    /// padded channels and inputs.
    fn words<const COUNT: usize>(&self, weights: &[f32], pack: impl Fn([f32; COUNT]) -> u32) -> Vec<u32> {
        let (n, inputs) = (self.shape.size, self.shape.inputs);
        let row = (n * inputs.div_ceil(COUNT)).next_multiple_of(self.run) * self.width;
        let mut out = Vec::with_capacity(n * row);
        for place in 0..n * n {
            for first in (0..inputs).step_by(COUNT) {
                for channel in 0..self.width {
                    let weight = |i: usize| {
                        let at = (channel * inputs + first + i) * n * n + place;
                        let exists = first + i < inputs;
                        if exists { weights.get(at).copied().unwrap_or(0.0) } else { 0.0 }
                    };
                    out.push(pack(std::array::from_fn(weight)));
                }
            }
            if (place + 1) % n == 0 {
                out.resize((place / n + 1) * row, 0);
            }
        }
        out
    }
}
