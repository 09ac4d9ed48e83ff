//! 1×1 convolutions that make pictures, with too few outputs for whole blocks of channels.

use super::direct::Direct;
use super::finish::{elu, relu};
use super::shape::ConvShape;
use crate::cpu::conv::patch::{Access, Source};
use crate::cpu::conv::prediction::{Chunk, Prediction};
use crate::cpu::tensor::element::Element;
use crate::plan::Activation;
use fovol_simd::{Simd, SimdF32, SimdF32Op};

/// Largest number of outputs for this method.
const FEW: usize = 4;

/// A convolution prepared for few outputs.
#[derive(Debug, Clone)]
pub struct Narrow {
    prediction: Prediction,
    /// Direct convolution, for inputs that are transformed during reading.
    pub direct: Direct,
    simd: Simd,
}

impl Narrow {
    /// Whether this method fits a convolution of `shape`.
    pub fn suits(shape: &ConvShape) -> bool {
        (shape.size, shape.stride) == (1, 1) && shape.outputs <= FEW
    }

    /// Prepares the convolution `direct`, given again its `weights` \[out, in\] and `bias` \[out\].
    pub fn new(direct: Direct, weights: &[f32], bias: &[f32], simd: Simd) -> Self {
        Self { prediction: Prediction::new(weights, bias), direct, simd }
    }

    /// Writes the output rows from `y` on to `out`. Returns false, and writes nothing, unless `sources` is one
    /// tensor that is read unchanged.
    pub fn rows<T: Element>(
        &self,
        sources: &[Source<'_>],
        y: usize,
        chunk: &mut Chunk,
        out: &mut [T],
    ) -> bool {
        let [source @ Source { access: Access::SAME, .. }] = *sources else { return false };
        let width = source.size()[1];
        for (row, out) in out.chunks_mut(width * self.direct.shape.outputs).enumerate() {
            self.simd.in_vectors(Row { conv: self, source, y: y + row, chunk, out });
        }
        true
    }
}

/// Operation that computes a row.
struct Row<'a, T> {
    conv: &'a Narrow,
    source: Source<'a>,
    y: usize,
    chunk: &'a mut Chunk,
    out: &'a mut [T],
}

impl<T: Element> SimdF32Op for Row<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run<V: SimdF32>(self, some: V) {
        let Self { conv, source, y, chunk, out } = self;
        let ConvShape { outputs, activation, .. } = conv.direct.shape;
        for (number, out) in out.chunks_mut(V::N * outputs).enumerate() {
            let count = out.len() / outputs;
            conv.prediction.run(source.rows, [y, number * V::N, count], chunk, some);
            for (i, pixel) in out.chunks_exact_mut(outputs).enumerate() {
                for (to, lanes) in pixel.iter_mut().zip(&chunk.predicted) {
                    *to = T::from_f32(match activation {
                        Activation::None => lanes[i],
                        Activation::Relu => relu(lanes[i]),
                        Activation::Elu => elu(lanes[i]),
                    });
                }
            }
        }
    }
}
