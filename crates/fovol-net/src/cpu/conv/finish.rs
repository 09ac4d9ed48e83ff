//! What becomes of sums before they are stored: values, activation, numbers of the kind that is stored.

use crate::cpu::element::Element;
use crate::cpu::simd::Work;
use crate::plan::Activation;

/// Sums that are finished at once: loops over as many become vectors.
const LANES: usize = 16;

/// What is no smaller, or no number, becomes 0 where nothing is negative: in recurrent networks it would stay.
pub const LARGEST: f32 = 3.38e38;

/// What sums of bytes are worth; for each channel.
#[derive(Debug, Clone)]
pub struct Worth {
    /// What one is worth.
    pub factors: Vec<f32>,
    /// What is added.
    pub bias: Vec<f32>,
}

/// The finishing of a block of sums.
pub struct Finish<'a, T> {
    /// \[pixel\]\[channel of the block\].
    pub sums: &'a [f32],
    /// Channels of the block.
    pub width: usize,
    pub worth: Option<&'a Worth>,
    pub activation: Activation,
    /// Pixels that are wanted.
    pub pixels: usize,
    /// Channels that are wanted.
    pub channels: usize,
    /// From the first of them on.
    pub out: &'a mut [T],
    /// From one pixel to the next.
    pub stride: usize,
}

impl<T: Element> Work for Finish<'_, T> {
    #[inline(always)]
    fn run(self) {
        let sums = self.sums.chunks_exact(self.width).take(self.pixels);
        for (sums, out) in sums.zip(self.out.chunks_mut(self.stride)) {
            finish(&sums[..self.channels], self.worth, self.activation, &mut out[..self.channels]);
        }
    }
}

/// Writes the values of `sums`, which are 32-bit integers where they are `worth` something and f32 otherwise, after
/// `activation` to `out`.
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

/// The value of a sum of bytes, a 32-bit integer in the place of an f32.
#[inline(always)]
fn value(sum: f32, factor: f32, bias: f32) -> f32 {
    (sum.to_bits() as i32) as f32 * factor + bias
}

/// x for 0 < x < [`LARGEST`], else 0.
#[inline(always)]
pub fn relu(x: f32) -> f32 {
    if x > 0.0 && x < LARGEST { x } else { 0.0 }
}

/// x for x > 0, else eˣ − 1.
#[inline]
pub fn elu(x: f32) -> f32 {
    if x > 0.0 { x } else { x.exp_m1() }
}
