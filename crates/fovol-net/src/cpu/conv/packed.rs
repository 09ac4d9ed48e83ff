use super::{ConvShape, Kernel};
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
    /// \[row of the window\]\[column\]\[input channel\]\[channel of the block\].
    pub weights: Vec<f32>,
    /// A number for each channel of the block.
    pub bias: Vec<f32>,
    /// What computes it.
    pub kernel: Kernel,
}

impl Packed {
    /// `weights` \[out, in, size, size\] and `bias` \[out\] for the kernels of `simd`.
    pub fn new(shape: &ConvShape, weights: &[f32], bias: &[f32], simd: Simd) -> Self {
        let mut blocks = Vec::new();
        let mut first = 0;
        while first < shape.outputs {
            let (width, kernel) = simd.block(shape.outputs - first);
            blocks.push(Block {
                first,
                width,
                weights: reorder(shape, weights, first, width),
                bias: (first..first + width).map(|c| bias.get(c).copied().unwrap_or(0.0)).collect(),
                kernel,
            });
            first += width;
        }
        Self { blocks }
    }

    /// All of them.
    pub fn blocks(&self) -> &[Block] {
        &self.blocks
    }
}

fn reorder(shape: &ConvShape, weights: &[f32], first: usize, width: usize) -> Vec<f32> {
    let (n, inputs) = (shape.size, shape.inputs);
    let mut out = Vec::with_capacity(n * n * inputs * width);
    for y in 0..n {
        for x in 0..n {
            for input in 0..inputs {
                for channel in first..first + width {
                    let at = ((channel * inputs + input) * n + y) * n + x;
                    out.push(if channel < shape.outputs { weights[at] } else { 0.0 });
                }
            }
        }
    }
    out
}
