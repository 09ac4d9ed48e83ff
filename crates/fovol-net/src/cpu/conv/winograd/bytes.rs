//! Transformed numbers as bytes: each place of a tile and channel has steps of its own, as numbers reach much further in some than
//! in others (after Andri et al., "Going Further With Winograd Convolutions: Tap-Wise Quantization for Efficient Inference on 4x4
//! Tiles", 2022).

use super::tile::{self, PLACES, REACH, SIDE};
use glam::Vec4;

/// The number that stands for 0, as bytes of inputs have no signs.
const ZERO: f32 = 128.0;
/// The largest of numbers with signs.
const MOST: f32 = 127.0;

/// What transformed inputs are multiplied by before they are rounded.
#[derive(Debug, Clone)]
pub struct Bytes {
    inputs: usize,
    /// \[place\]\[even, odd\]\[half the input channel\], with ones up to [`Self::pairs`].
    factors: Vec<f32>,
}

/// Weights of some output channels.
pub struct Quantised {
    /// \[channel of the block, in\]: whole numbers, -127…127.
    pub kernels: Vec<[f32; PLACES]>,
    /// What the sum of products is worth: \[place\]\[channel of the block\].
    pub worth: Vec<f32>,
    width: usize,
    /// The sums of weights: \[place\]\[channel of the block\].
    sums: Vec<f32>,
}

impl Bytes {
    /// For `inputs` that reach as far as `reach` \[place\]\[channel\] once they are transformed; what is further is cut off.
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

    /// The factors of a `place` for the `count` pairs of channels from `first` on: of those that are even and odd.
    #[inline(always)]
    pub fn factors(&self, place: usize, first: usize, count: usize) -> [&[f32]; 2] {
        let pairs = pairs(self.inputs);
        [0, 1].map(|parity| &self.factors[(2 * place + parity) * pairs + first..][..count])
    }

    /// Transformed `kernels` \[channel of the block, in\] for inputs that are multiplied by these, of a block of `width` channels.
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
    /// What is added to each pixel of a tile, \[pixel\]\[channel of the block\]: `bias`, less what comes of bytes that stand for 0.
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

/// Pairs of channels, with those up to whole vectors of them.
fn pairs(inputs: usize) -> usize {
    inputs.div_ceil(2).next_multiple_of(super::WORDS)
}
