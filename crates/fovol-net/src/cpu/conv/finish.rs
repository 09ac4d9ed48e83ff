//! Finishes the sums of convolutions: dequantisation, bias, activation and conversion to the stored type.

use crate::cpu::tensor::element::Element;
use crate::plan::Activation;
use fovol_simd::SimdOp;

/// Number of sums that are finished at once. The compiler vectorises loops of this length.
const LANES: usize = 16;

/// Upper limit of ReLU. Larger values and NaN become 0, since they would stay forever in the states of recurrent
/// networks.
pub const LARGEST: f32 = 3.38e38;

/// Dequantisation of int8 sums, for each channel.
#[derive(Debug, Clone)]
pub struct Worth {
    /// Factor of a sum.
    pub factors: Vec<f32>,
    /// Bias, added afterwards.
    pub bias: Vec<f32>,
}

/// Operation that finishes a block of sums.
pub struct Finish<'a, T> {
    /// Sums, \[pixel\]\[channel of the block\].
    pub sums: &'a [f32],
    /// Channels of the block.
    pub width: usize,
    pub worth: Option<&'a Worth>,
    pub activation: Activation,
    /// Number of pixels to store.
    pub pixels: usize,
    /// Number of channels to store.
    pub channels: usize,
    /// Destination, from the first of these pixels and channels on.
    pub out: &'a mut [T],
    /// Distance between pixels in the destination.
    pub stride: usize,
}

impl<T: Element> SimdOp for Finish<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let sums = self.sums.chunks_exact(self.width).take(self.pixels);
        for (sums, out) in sums.zip(self.out.chunks_mut(self.stride)) {
            finish(&sums[..self.channels], self.worth, self.activation, &mut out[..self.channels]);
        }
    }
}

/// Dequantises `sums`, applies `activation` and writes to `out`. With `worth` the sums are 32-bit integers, else
/// f32.
#[inline(always)]
pub fn finish<T: Element>(sums: &[f32], worth: Option<&Worth>, activation: Activation, out: &mut [T]) {
    match (worth, activation) {
        (None, Activation::None) => each(sums, None, out, |v| v),
        (None, Activation::Relu) => each(sums, None, out, relu),
        (None, Activation::Elu) => each(sums, None, out, elu),
        (worth, Activation::None) => each(sums, worth, out, |v| v),
        (worth, Activation::Relu) => each(sums, worth, out, relu),
        (worth, Activation::Elu) => each(sums, worth, out, elu),
    }
}

#[inline(always)]
fn each<T: Element>(sums: &[f32], worth: Option<&Worth>, out: &mut [T], activation: impl Fn(f32) -> f32) {
    let ((sums, last), (out, last_out)) = (sums.as_chunks::<LANES>(), out.as_chunks_mut::<LANES>());
    for (i, (to, sums)) in out.iter_mut().zip(sums).enumerate() {
        let mut values = *sums;
        if let Some(Worth { factors, bias }) = worth {
            let (factors, bias) = (&factors.as_chunks::<LANES>().0[i], &bias.as_chunks::<LANES>().0[i]);
            for k in 0..LANES {
                values[k] = value(sums[k], factors[k], bias[k]);
            }
        }
        let mut finished = [T::default(); LANES];
        for k in 0..LANES {
            finished[k] = T::from_f32(activation(values[k]));
        }
        *to = finished;
    }
    let first = sums.len() * LANES;
    for (k, (to, &sum)) in last_out.iter_mut().zip(last).enumerate() {
        let value = match worth {
            Some(Worth { factors, bias }) => value(sum, factors[first + k], bias[first + k]),
            None => sum,
        };
        *to = T::from_f32(activation(value));
    }
}

/// Dequantises a sum of int8 products, a 32-bit integer in the bits of an f32.
#[inline(always)]
fn value(sum: f32, factor: f32, bias: f32) -> f32 {
    (sum.to_bits() as i32) as f32 * factor + bias
}

/// ReLU for finite values: x for 0 < x < [`LARGEST`], else 0.
#[inline(always)]
pub fn relu(x: f32) -> f32 {
    if x > 0.0 && x < LARGEST { x } else { 0.0 }
}

/// ELU: x for x > 0, else eˣ − 1.
#[inline]
pub fn elu(x: f32) -> f32 {
    if x > 0.0 { x } else { x.exp_m1() }
}
