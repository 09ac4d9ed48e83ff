//! Transformed inputs and weights as bytes. Each place of a tile and channel has its own step, because ranges
//! differ widely. After Andri et al., "Going Further With Winograd Convolutions: Tap-Wise Quantization for
//! Efficient Inference on 4x4 Tiles" (2022).

use super::tile::{self, PLACES, REACH, SIDE};
use glam::Vec4;

/// Byte that stands for 0, since input bytes are unsigned.
const ZERO: f32 = 128.0;
/// Largest signed byte.
const MOST: f32 = 127.0;

/// Quantisation of transformed inputs.
#[derive(Debug, Clone)]
pub struct Bytes {
    inputs: usize,
    /// Factors before rounding, \[place\]\[even, odd\]\[half the input channel\], padded with ones up to [`pairs`].
    factors: Vec<f32>,
}

/// Quantised weights of some output channels.
pub struct Quantised {
    /// Weights, \[channel of the block, in\]: integers −127…127.
    pub kernels: Vec<[f32; PLACES]>,
    /// Steps of sums of products, \[place\]\[channel of the block\].
    pub worth: Vec<f32>,
    width: usize,
    /// Sums of weights, \[place\]\[channel of the block\].
    sums: Vec<f32>,
}

impl Bytes {
    /// Makes factors for `inputs` channels whose transformed values reach up to `reach` \[place\]\[channel\].
    /// Larger values are clamped.
    pub fn new(inputs: usize, reach: &[f32]) -> Self {
        let pairs = pairs(inputs);
        let mut factors = vec![1.0; PLACES * 2 * pairs];
        for (place, reach) in reach.chunks_exact(inputs).enumerate() {
            for (channel, reach) in reach.iter().enumerate() {
                factors[(2 * place + channel % 2) * pairs + channel / 2] = MOST / reach;
            }
        }
        Self { inputs, factors }
    }

    /// Factors of a `place` for `count` pairs of channels from `first` on: of the even channels and of the odd
    /// ones.
    #[inline(always)]
    pub fn factors(&self, place: usize, first: usize, count: usize) -> [&[f32]; 2] {
        let pairs = pairs(self.inputs);
        [0, 1].map(|parity| &self.factors[(2 * place + parity) * pairs + first..][..count])
    }

    /// Quantises transformed `kernels` \[channel of the block, in\] for inputs with these factors, in a block of
    /// `width` channels.
    pub fn quantised(&self, kernels: &[[f32; PLACES]], width: usize) -> Quantised {
        let pairs = pairs(self.inputs);
        let mut kernels = kernels.to_vec();
        let (mut worth, mut sums) = (vec![0.0; PLACES * width], vec![0.0; PLACES * width]);
        for (output, kernels) in kernels.chunks_exact_mut(self.inputs).enumerate() {
            for place in 0..PLACES {
                let factor = |channel: usize| self.factors[(2 * place + channel % 2) * pairs + channel / 2];
                kernels.iter_mut().enumerate().for_each(|(channel, kernel)| kernel[place] /= factor(channel));
                let most = kernels.iter().fold(0.0f32, |most, kernel| most.max(kernel[place].abs()));
                let one = if most > 0.0 { most / MOST } else { 1.0 };
                kernels.iter_mut().for_each(|kernel| kernel[place] = (kernel[place] / one).round());
                worth[place * width + output] = one;
                sums[place * width + output] = kernels.iter().map(|kernel| kernel[place]).sum();
            }
        }
        Quantised { kernels, worth, width, sums }
    }
}

impl Quantised {
    /// Bias of each pixel of a tile, \[pixel\]\[channel of the block\]: `bias` minus the contribution of the byte
    /// that stands for 0.
    pub fn bias(&self, bias: &[f32]) -> Vec<f32> {
        let mut biases = vec![0.0; SIDE * SIDE * self.width];
        for channel in 0..self.width {
            let zeros: [[Vec4; REACH]; REACH] = std::array::from_fn(|x| {
                std::array::from_fn(|y| {
                    let at = (y * REACH + x) * self.width + channel;
                    Vec4::splat(ZERO * self.sums[at] * self.worth[at])
                })
            });
            let columns = zeros.map(tile::outputs);
            for y in 0..SIDE {
                let row = tile::outputs(columns.map(|column| column[y]));
                for x in 0..SIDE {
                    biases[(y * SIDE + x) * self.width + channel] = bias[channel] - row[x].x;
                }
            }
        }
        biases
    }
}

/// Number of pairs of channels, padded to whole vectors.
fn pairs(inputs: usize) -> usize {
    inputs.div_ceil(2).next_multiple_of(super::words::WORDS)
}
