//! Losses of reconstructed clips.
//!
//! L = λ_s·L_s + λ_t·L_t as in section "Loss" of the paper, with the normalisation of the authors' code
//! (docs/guide/src/internals/algorithm.md, section 7.1):
//!
//! * L_s = 1/T · Σ_i (1 − e^(−0.5·i)) · (λ₁·perceptual + λ₂·L1) of each frame ([`spatial`], [`perceptual`]),
//! * L_t = λ₃ · mean over pairs of |(y_i − y_j) − (r_i − r_j)| + λ₄ · Σ_i |y_i − warp(y_{i−1})| ([`temporal`],
//!   [`flow`]).
//!
//! Optional terms are squared differences of pixels and of block averages. With [`LossConfig::logarithmic`] the
//! logarithms of the terms are added.
//!
//! Every |·| is the mean over channels and pixels of a clip, and L the mean over the clips of a batch. So the result
//! does not depend on how clips are batched, not even with logarithms. Pictures are \[N, 3, H, W\], sRGB in 0…1, as
//! displayed. The paper's perceptual measure needs weights that are not shipped; the default needs none.
//!
//! ```
//! use fovol_train::loss::{Clip, LossConfig, Losses};
//! use tch::{Device, Kind, Tensor};
//!
//! let losses = Losses::new(&LossConfig::default(), Device::Cpu)?;
//! let pictures = || Tensor::rand([4, 1, 3, 48, 64], (Kind::Float, Device::Cpu));
//! let outputs = pictures().set_requires_grad(true);
//! let clip = Clip { outputs: &outputs.unbind(0), references: &pictures().unbind(0), motion: None };
//! let terms = losses.clip(&clip)?;
//! terms.total.backward();
//! assert!(outputs.grad().abs().max().double_value(&[]) > 0.0);
//! # Ok::<(), fovol_train::Error>(())
//! ```

mod config;
mod convert;
pub mod deepfovea;
pub mod flow;
mod legacy;
pub mod perceptual;
mod pictures;
#[cfg(test)]
mod reference;
pub mod spatial;
pub mod ssim;
pub mod temporal;
#[cfg(test)]
mod testing;
#[cfg(test)]
mod tests;
pub mod vgg;

pub use config::LossConfig;
pub use convert::{Converted, convert_vgg};
pub use flow::FlowSource;
pub use perceptual::{
    L1MsSsim, Lpips, Perceptual, PerceptualConfig, PlainSsim, RandomVgg, VggDistance, VggFile,
};
pub use spatial::WarmUp;
pub use temporal::Pairs;

use crate::{Error, Result};
use pictures::{mean, picture_shape, zeros};
use std::ops::Range;
use tch::{Device, Tensor};

/// Outputs and references of a batch of N clips, or of their beginning.
#[derive(Debug, Clone, Copy)]
pub struct Clip<'a> {
    /// Outputs of the network for frames 0, 1, …: \[N, 3, H, W\] each. Detached outputs receive no gradients.
    pub outputs: &'a [Tensor],
    /// Reference frames: \[N, 3, H, W\] each.
    pub references: &'a [Tensor],
    /// Motion from each pixel of frame i to its position in frame i − 1, in pixels, x right, then y down: \[N, 2, H,
    /// W\] each. The motion of frame 0 is ignored. Only [`FlowSource::Exact`] needs it.
    pub motion: Option<&'a [Tensor]>,
}

/// The loss and its terms, as scalars.
#[derive(Debug)]
pub struct Terms {
    /// The value to minimise.
    pub total: Tensor,
    /// L_s: weighted sum of `perceptual`, `l1`, `squares` and `coarse`, or of their logarithms.
    pub spatial: Tensor,
    /// 1/T · Σ_i w_i · perceptual measure.
    pub perceptual: Tensor,
    /// 1/T · Σ_i w_i · mean absolute difference.
    pub l1: Tensor,
    /// 1/T · Σ_i w_i · mean squared difference.
    pub squares: Tensor,
    /// 1/T · Σ_i w_i · mean squared difference of averages over 4×4 and over 16×16 pixels.
    pub coarse: [Tensor; 2],
    /// Mean absolute error of the differences between frames, averaged over pairs.
    pub temporal: Tensor,
    /// Σ_i of the mean absolute difference between frame i and the warped frame i − 1.
    pub flow: Tensor,
}

impl Terms {
    /// All terms by name. Waits for the device.
    pub fn values(&self) -> [(&'static str, f64); 9] {
        let Self { total, spatial, perceptual, l1, squares, coarse, temporal, flow } = self;
        [
            ("total", total),
            ("spatial", spatial),
            ("perceptual", perceptual),
            ("l1", l1),
            ("squares", squares),
            ("coarse-4", &coarse[0]),
            ("coarse-16", &coarse[1]),
            ("temporal", temporal),
            ("flow", flow),
        ]
        .map(|(name, term)| (name, term.double_value(&[])))
    }
}

/// Added to terms before their logarithm, so that nearly perfect clips do not dominate.
const LEAST_TERM: f64 = 2e-6;

/// A loss with its configuration and weights.
#[derive(Debug)]
pub struct Losses {
    config: LossConfig,
    perceptual: Box<dyn Perceptual>,
}

impl Losses {
    /// Builds the loss of `config`, with its weights on `device`.
    ///
    /// # Errors
    /// Files that cannot be read or hold other weights.
    pub fn new(config: &LossConfig, device: Device) -> Result<Self> {
        Ok(Self { perceptual: config.perceptual.build(device)?, config: config.clone() })
    }

    /// The configuration.
    pub fn config(&self) -> &LossConfig {
        &self.config
    }

    /// The perceptual measure.
    pub fn perceptual(&self) -> &dyn Perceptual {
        self.perceptual.as_ref()
    }

    /// Loss of a whole clip.
    ///
    /// # Errors
    /// The clip has no frames, has unequal lengths or sizes, lacks the motion, or is too small for the perceptual
    /// measure.
    pub fn clip(&self, clip: &Clip<'_>) -> Result<Terms> {
        let length = clip.outputs.len();
        self.frames(clip, 0..length, length)
    }

    /// Contribution of `frames` to the loss of a clip of `length` frames, for truncated backpropagation. The
    /// contributions of all parts add up to the whole loss.
    ///
    /// `clip` holds at least all frames from the first up to the last of `frames`. Earlier outputs are compared with;
    /// they are best detached.
    ///
    /// # Errors
    /// Errors of [`Losses::clip`].
    pub fn frames(&self, clip: &Clip<'_>, frames: Range<usize>, length: usize) -> Result<Terms> {
        check(clip, &frames, length)?;
        let config = &self.config;
        if config.logarithmic && frames != (0..length) {
            return Err(Error::Config(
                "logarithms of parts of a clip do not add up; leave out `logarithmic`, or `truncate` at no fewer than all \
                 `frames`"
                    .into(),
            ));
        }
        let [perceptual, l1, squares, fine, coarse] = self.spatial(clip, frames.clone(), length)?;
        let temporal = self.differences(clip, frames.clone(), length);
        let flow = self.flow(clip, frames, length)?;
        let of_clips = self.sum([
            (&perceptual, config.perceptual_weight),
            (&l1, config.l1_weight),
            (&squares, config.squares_weight),
            (&fine, config.coarse_weight),
            (&coarse, config.coarse_weight),
        ]);
        let between = self.sum([(&temporal, config.difference_weight), (&flow, config.flow_weight)]);
        let total = mean(&(&of_clips * config.spatial_weight + between * config.temporal_weight));
        let [spatial, perceptual, l1, squares, fine, coarse, temporal, flow] =
            [of_clips, perceptual, l1, squares, fine, coarse, temporal, flow].map(|term| mean(&term));
        Ok(Terms { total, spatial, perceptual, l1, squares, coarse: [fine, coarse], temporal, flow })
    }

    /// Weighted sum of terms, or of their logarithms.
    fn sum<const N: usize>(&self, terms: [(&Tensor, f64); N]) -> Tensor {
        let weighed = terms.map(|(term, weight)| match self.config.logarithmic && weight != 0.0 {
            true => (term + LEAST_TERM).log() * weight,
            false => term * weight,
        });
        weighed.into_iter().sum()
    }

    /// The perceptual term, L1, squares, and squares of two block averages.
    fn spatial(&self, clip: &Clip<'_>, frames: Range<usize>, length: usize) -> Result<[Tensor; 5]> {
        let config = &self.config;
        let wanted =
            [config.perceptual_weight, config.l1_weight, config.squares_weight, config.coarse_weight];
        let mut sums = [(); 5].map(|()| zeros(&clip.outputs[0]));
        for i in frames {
            let weight = self.config.warm_up.weight(i) / length as f64;
            if weight > 0.0 {
                let (output, reference) = (&clip.outputs[i], &clip.references[i]);
                let found = spatial::frame_difference(self.perceptual(), wanted, output, reference)?;
                let [fine, coarse] = found.coarse;
                let found = [found.perceptual, found.l1, found.squares, fine, coarse];
                sums.iter_mut().zip(found).for_each(|(sum, found)| *sum += found * weight);
            }
        }
        Ok(sums)
    }

    /// Term of the differences between frames.
    fn differences(&self, clip: &Clip<'_>, frames: Range<usize>, length: usize) -> Tensor {
        let pairs = self.config.pairs;
        if self.config.difference_weight == 0.0 || pairs.count(length) == 0 {
            return zeros(&clip.outputs[0]);
        }
        let both = clip.outputs.iter().zip(clip.references);
        let errors: Vec<Tensor> =
            both.take(frames.end).map(|(output, reference)| output - reference).collect();
        temporal::difference_sum(&errors, frames, pairs) / pairs.count(length) as f64
    }

    /// Term of the optical flow.
    fn flow(&self, clip: &Clip<'_>, frames: Range<usize>, length: usize) -> Result<Tensor> {
        let mut sum = zeros(&clip.outputs[0]);
        if self.config.flow_weight == 0.0 {
            return Ok(sum);
        }
        for i in frames.start.max(1)..frames.end {
            let motion = self.motion(clip, i)?;
            let [reference, before] = [i, i - 1].map(|i| &clip.references[i]);
            let most = self.config.flow_confidence;
            let confident = most.map(|most| temporal::confident_pixels(reference, before, &motion, most));
            let [output, previous] = [i, i - 1].map(|i| &clip.outputs[i]);
            sum += temporal::flow_difference(output, previous, &motion, confident.as_ref());
        }
        let divisor = if self.config.average_flow { length.saturating_sub(1).max(1) } else { 1 };
        Ok(sum / divisor as f64)
    }

    /// Motion from frame `i` to frame `i` − 1.
    fn motion(&self, clip: &Clip<'_>, i: usize) -> Result<Tensor> {
        if let Some(search) = self.config.flow.search() {
            return Ok(search.motion(&clip.references[i], &clip.references[i - 1]));
        }
        let given = clip.motion.and_then(|motion| motion.get(i)).ok_or_else(|| {
            let mend = "give it, or take the flow from \"single-level\" or \"hierarchical\" search";
            Error::Input(format!("the motion of frame {i} is missing; {mend}"))
        })?;
        let size = clip.outputs[i].size();
        let expected = [size[0], 2, size[2], size[3]];
        if given.size() != expected {
            return Err(Error::Input(format!(
                "the motion of frame {i} is {:?}; give {expected:?}",
                given.size()
            )));
        }
        Ok(given.shallow_clone())
    }
}

/// Checks that `clip` holds all frames that the loss of `frames` needs.
fn check(clip: &Clip<'_>, frames: &Range<usize>, length: usize) -> Result<()> {
    let enough = clip.outputs.len() == clip.references.len() && frames.end <= clip.outputs.len();
    if !enough || frames.is_empty() || length < frames.end {
        return Err(Error::Input(format!(
            "frames {frames:?} of a clip of {length} cannot be judged by {} outputs and {} references; give both of \
             all frames up to the last one",
            clip.outputs.len(),
            clip.references.len()
        )));
    }
    let size = clip.outputs[0].size();
    for (output, reference) in clip.outputs.iter().zip(clip.references) {
        picture_shape(output, reference)?;
        if output.size() != size {
            return Err(Error::Input(format!(
                "a clip has pictures of {size:?} and of {:?}; give one size",
                output.size()
            )));
        }
    }
    Ok(())
}
