//! Convolutions. Inputs are assembled to patches, weights are packed in the order of use, and kernels keep a block
//! of pixels × channels in registers.

#[cfg(target_arch = "x86_64")]
pub(super) mod amx;
#[cfg(target_arch = "x86_64")]
pub(super) mod avx2;
#[cfg(target_arch = "x86_64")]
pub(super) mod avx512;
pub mod call;
mod direct;
mod finish;
pub(super) mod kernels;
mod narrow;
pub mod pack;
mod packed;
pub mod pair;
pub mod patch;
pub(super) mod portable;
pub mod prediction;
pub mod shape;
mod winograd;
mod words;

pub use finish::elu;
pub use shape::{Arithmetic, ConvShape};
pub use winograd::{Distances, note_transformed};

use crate::cpu::tensor::Tensor;
use crate::cpu::tensor::element::Element;
use direct::{Direct, DirectScratch};
use fovol_simd::{Bf16, Simd};
use narrow::Narrow;
use patch::Source;
use prediction::Chunk;
use rayon::prelude::*;
use shape::ROWS;
use winograd::Winograd;

/// A convolution with its weights, prepared for one instruction set.
#[derive(Debug, Clone)]
pub enum PreparedConv {
    /// Direct convolution.
    Direct(Direct),
    /// Winograd convolution, with fewer products.
    Winograd(Winograd),
    /// 1×1 convolution with few outputs.
    Narrow(Narrow),
    /// Direct convolution that reads its inputs twice, with the upper and the lower bf16 of each weight.
    Split(Direct),
}

impl PreparedConv {
    /// Prepares a convolution of `shape` with `weights` \[out, in, size, size\] and `bias` \[out\].
    pub fn new(shape: &ConvShape, weights: &[f32], bias: &[f32], simd: Simd, arithmetic: Arithmetic) -> Self {
        if Winograd::suits(shape, simd, &arithmetic) {
            Self::Winograd(Winograd::new(shape, weights, bias, simd, &arithmetic))
        } else if arithmetic == Arithmetic::SplitBf16 {
            let twice = ConvShape { inputs: 2 * shape.inputs, ..*shape };
            Self::Split(Direct::new(&twice, &split(shape, weights), bias, simd, Arithmetic::Bf16))
        } else {
            let is_narrow = arithmetic == Arithmetic::F32 && Narrow::suits(shape);
            let direct = Direct::new(shape, weights, bias, simd, arithmetic);
            match is_narrow {
                true => Self::Narrow(Narrow::new(direct, weights, bias, simd)),
                false => Self::Direct(direct),
            }
        }
    }

    fn shape(&self) -> &ConvShape {
        match self {
            Self::Direct(conv) | Self::Split(conv) => &conv.shape,
            Self::Winograd(conv) => conv.shape(),
            Self::Narrow(conv) => &conv.direct.shape,
        }
    }

    /// Number of output channels.
    pub fn outputs(&self) -> usize {
        self.shape().outputs
    }

    /// Writes the convolution of the concatenated `sources` to `out`, whose buffer is reused.
    ///
    /// # Panics
    /// When the sources have not as many channels as the weights.
    pub fn run<T: Element>(&self, sources: &[Source<'_>], out: &mut Tensor<T>) {
        let ConvShape { stride, outputs, .. } = *self.shape();
        let [height, width] = sources[0].size().map(|side| side.div_ceil(stride));
        out.resize([height, width, outputs]);
        let bands = out.data.par_chunks_mut(ROWS * width * outputs).enumerate();
        bands.for_each_init(Scratch::default, |scratch, (band, out)| {
            self.rows(sources, band * ROWS, scratch, out);
        });
    }

    /// Writes output rows from `y` on to `out`, as many as fit.
    ///
    /// # Panics
    /// When the sources have not as many channels as the weights.
    pub fn rows<T: Element>(&self, sources: &[Source<'_>], y: usize, scratch: &mut Scratch, out: &mut [T]) {
        match self {
            Self::Direct(conv) => conv.rows(sources, y, &mut scratch.direct, out),
            Self::Winograd(conv) => conv.rows(sources, y, &mut scratch.winograd, out),
            Self::Narrow(conv) => {
                if !conv.rows(sources, y, &mut scratch.chunk, out) {
                    conv.direct.rows(sources, y, &mut scratch.direct, out);
                }
            }
            Self::Split(conv) => conv.rows(&[sources, sources].concat(), y, &mut scratch.direct, out),
        }
    }
}

/// Splits `weights` \[out, in, size, size\] into sums of two bf16. For each output the upper parts of all inputs
/// come first, then the lower ones.
fn split(shape: &ConvShape, weights: &[f32]) -> Vec<f32> {
    let mut halves = Vec::with_capacity(2 * weights.len());
    for weights in weights.chunks_exact(shape.inputs * shape.size * shape.size) {
        let upper = weights.iter().map(|&w| Bf16::from_f32(w).to_f32());
        halves.extend(upper.clone());
        halves.extend(weights.iter().zip(upper).map(|(w, upper)| w - upper));
    }
    halves
}

/// Scratch memory of one thread.
#[derive(Debug, Default)]
pub struct Scratch {
    direct: DirectScratch,
    winograd: winograd::Scratch,
    chunk: Chunk,
}

#[cfg(test)]
mod tests;
