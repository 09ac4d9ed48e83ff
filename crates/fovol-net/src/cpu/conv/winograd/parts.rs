//! Parts of a convolution by Winograd's algorithm, and their sizes.

use super::super::call::Kernel;
use super::super::kernels;
use super::super::patch::Patch;
use super::super::shape::{Arithmetic, ConvShape};
use super::bytes::Bytes;
use super::words::WORDS;
use fovol_simd::{AlignedBuf, Simd};

/// A convolution prepared for Winograd's algorithm.
#[derive(Debug, Clone)]
pub struct Winograd {
    pub blocks: Vec<Block>,
    pub shape: ConvShape,
    pub factors: Factors,
    pub simd: Simd,
}

/// Type of the factors of products.
#[derive(Debug, Clone)]
pub enum Factors {
    F32,
    /// Pairs of bf16.
    Bf16,
    /// Quadruples of bytes, from inputs that are pairs of bf16.
    Bytes(Bytes),
}

impl Factors {
    pub fn arithmetic(&self) -> Arithmetic {
        match self {
            Self::F32 => Arithmetic::F32,
            Self::Bf16 => Arithmetic::Bf16,
            Self::Bytes(_) => Arithmetic::Int8 { steps: Vec::new(), reach: None },
        }
    }

    /// Number of transformed values in a word.
    pub fn count(&self) -> usize {
        self.arithmetic().count()
    }

    /// Number of inputs in a word of a patch.
    pub fn loaded(&self) -> usize {
        self.count().min(2)
    }
}

/// Weights of some output channels.
#[derive(Debug, Clone)]
pub struct Block {
    pub first: usize,
    pub width: usize,
    /// Weights, \[place\]\[word of a pixel\]\[channel of the block\].
    pub weights: AlignedBuf,
    /// Steps of int8 sums, \[place\]\[channel of the block\].
    pub worth: Option<Vec<f32>>,
    /// Bias, \[pixel of a tile\]\[channel of the block\].
    pub bias: Vec<f32>,
    pub kernel: Kernel,
}

/// Scratch memory of one thread.
#[derive(Debug, Default)]
pub struct Scratch {
    /// Inputs, \[row\]\[column\]\[word of a pixel\].
    pub patch: Patch,
    /// Transformed inputs, \[place\]\[tile\]\[word of a pixel\], padded to whole vectors with undefined words.
    pub transformed: AlignedBuf,
    /// Sums of products, \[place\]\[tile\]\[channel of the block\].
    pub products: AlignedBuf,
}

/// Part of the output.
#[derive(Clone, Copy)]
pub struct Strip {
    /// First row and column.
    pub place: [usize; 2],
    /// First row within the patch.
    pub row: usize,
    /// Number of tiles side by side: whole groups.
    pub tiles: usize,
}

impl Winograd {
    /// Shape of the convolution.
    pub fn shape(&self) -> &ConvShape {
        &self.shape
    }

    /// Words of a transformed pixel, without padding.
    pub fn words(&self) -> usize {
        self.shape.inputs.div_ceil(self.factors.count())
    }

    /// Words of a pixel of the patch, with padding.
    pub fn loaded_pixel(&self) -> usize {
        self.shape.inputs.div_ceil(self.factors.loaded()).next_multiple_of(WORDS)
    }

    /// Words of a transformed pixel, with padding.
    pub fn pixel(&self) -> usize {
        self.loaded_pixel() * self.factors.loaded() / self.factors.count()
    }

    /// Number of pixels that a kernel computes at once.
    pub fn group(&self) -> usize {
        kernels::group(self.simd, &self.factors.arithmetic())
    }
}
