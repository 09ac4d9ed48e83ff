//! What a clip is judged by.
//!
//! L = λ_s·L_s + λ_t·L_t, as section "Loss" of the paper has it, with the normalisation of the authors' code:
//!
//! * L_s = 1/T · Σ_i (1 − e^(−0.5·i)) · (λ₁·perceptual + λ₂·L1) of each frame ([`spatial`], [`perceptual`]),
//! * L_t = λ₃ · mean over pairs of |(y_i − y_j) − (r_i − r_j)| + λ₄ · Σ_i |y_i − warp(y_{i−1})| ([`temporal`], [`flow`]).
//!
//! With [`LossConfig::logarithmic`] logarithms of the terms are added instead, and squares may count too,
//! of pixels and of means over some.
//!
//! Every |·| is the mean over channels and pixels of a clip, and L the mean over the clips of a batch: how many are judged
//! together makes no difference, also not to logarithms. Pictures are \[N, 3, H, W\], sRGB in 0…1, as displayed.
//! The perceptual measure of the paper needs weights that are not shipped; the default needs none.
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
#[cfg(test)]
mod reference;
pub mod spatial;
pub mod ssim;
pub mod temporal;
#[cfg(test)]
mod testing;
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
use std::ops::Range;
use tch::{Device, Tensor};

/// A clip, or its beginning: one picture of each of N clips for every frame.
#[derive(Debug, Clone, Copy)]
pub struct Clip<'a> {
    /// What the network made of frames 0, 1, …: \[N, 3, H, W\] each. What is detached gets no gradients.
    pub outputs: &'a [Tensor],
    /// What it should have made of them.
    pub references: &'a [Tensor],
    /// Pixels from each position of frame i to where this was in frame i − 1, x right, then y down: \[N, 2, H, W\]
    /// each; that of frame 0 is not looked at. Needed for [`FlowSource::Exact`] alone.
    pub motion: Option<&'a [Tensor]>,
}

/// The loss and its parts: scalars.
#[derive(Debug)]
pub struct Terms {
    /// What is to be minimised.
    pub total: Tensor,
    /// L_s: λ₁·`perceptual` + λ₂·`l1` and what `squares` weigh, or of their logarithms.
    pub spatial: Tensor,
    /// 1/T · Σ_i w_i · the perceptual measure.
    pub perceptual: Tensor,
    /// 1/T · Σ_i w_i · the mean absolute difference.
    pub l1: Tensor,
    /// 1/T · Σ_i w_i · the mean squared difference.
    pub squares: Tensor,
    /// The same of means over 4×4 and over 16×16 pixels.
    pub coarse: [Tensor; 2],
    /// The mean over pairs of frames of the mean absolute difference of their differences.
    pub temporal: Tensor,
    /// Σ_i of the mean absolute difference of frame i from frame i − 1 along the motion.
    pub flow: Tensor,
}

impl Terms {
    /// The parts by name. Waits for the device.
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

/// What is added to terms before their logarithm: clips that are nearly perfect need not become more so.
const LEAST_TERM: f64 = 2e-6;

/// A loss, ready to be taken.
#[derive(Debug)]
pub struct Losses {
    config: LossConfig,
    perceptual: Box<dyn Perceptual>,
}

impl Losses {
    /// The loss that `config` describes, with what weights it has on `device`.
    ///
    /// # Errors
    /// Files that cannot be read or hold other weights.
    pub fn new(config: &LossConfig, device: Device) -> Result<Self> {
        Ok(Self { perceptual: config.perceptual.build(device)?, config: config.clone() })
    }

    /// What it is made from.
    pub fn config(&self) -> &LossConfig {
        &self.config
    }

    /// The perceptual measure.
    pub fn perceptual(&self) -> &dyn Perceptual {
        self.perceptual.as_ref()
    }

    /// The loss of a whole clip.
    ///
    /// # Errors
    /// A clip without frames, of unequal lengths or sizes, without the motion that is needed, or too small for the
    /// perceptual measure.
    pub fn clip(&self, clip: &Clip<'_>) -> Result<Terms> {
        let length = clip.outputs.len();
        self.frames(clip, 0..length, length)
    }

    /// The part that `frames` have in the loss of a clip of `length` frames, for gradients that go back over a few
    /// frames only: parts of a clip add up to the whole.
    ///
    /// `clip` holds at least all frames from the first up to the last of `frames`. Earlier outputs are compared
    /// with; they are best detached.
    ///
    /// # Errors
    /// As [`Losses::clip`].
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

    /// The sum of terms, or of their logarithms, with their weights.
    fn sum<const N: usize>(&self, terms: [(&Tensor, f64); N]) -> Tensor {
        let weighed = terms.map(|(term, weight)| match self.config.logarithmic && weight != 0.0 {
            true => (term + LEAST_TERM).log() * weight,
            false => term * weight,
        });
        weighed.into_iter().sum()
    }

    /// The perceptual term, L1, squares, and squares of means.
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

    /// The term of differences between frames.
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

    /// The term of optical flow.
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

    /// The motion from frame `i` to frame `i` − 1.
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

/// Whether `clip` has all that the loss of `frames` looks at.
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

/// The shape of two pictures, \[N, C, H, W\], if they can be compared.
fn picture_shape(output: &Tensor, reference: &Tensor) -> Result<[i64; 4]> {
    let (found, other) = (output.size(), reference.size());
    match found[..] {
        [n, c, height, width] if found == other && n * c * height * width > 0 => Ok([n, c, height, width]),
        _ => Err(Error::Input(format!(
            "pictures of {found:?} cannot be compared with {other:?}; give two of [batch, channels, rows, columns]"
        ))),
    }
}

/// The mean over everything: a scalar.
fn mean(tensor: &Tensor) -> Tensor {
    tensor.mean(None)
}

/// The mean of each of the \[N, C, H, W\] or \[N, C\] of a batch: \[N\].
fn means(tensor: &Tensor) -> Tensor {
    tensor.flatten(1, -1).mean_dim([1i64].as_slice(), false, None)
}

/// 0 for each of the \[N, C, H, W\] of a batch, like its numbers: \[N\].
fn zeros(pictures: &Tensor) -> Tensor {
    Tensor::zeros([pictures.size()[0]], (pictures.kind(), pictures.device()))
}

#[cfg(test)]
mod tests {
    use super::testing::{EXACT, pair, pictures, value, worst_slope};
    use super::*;

    struct Made {
        outputs: Vec<Tensor>,
        references: Vec<Tensor>,
        motion: Vec<Tensor>,
    }

    fn made(length: usize) -> Made {
        let (outputs, references) = (0..length).map(|t| pair([2, 12, 14], t as f64 * 0.4)).unzip();
        let motion = |t: usize| pictures([2, 12, 14], t as f64 + 9.0, EXACT).narrow(1, 0, 2) * 3.0 - 1.4;
        Made { outputs, references, motion: (0..length).map(motion).collect() }
    }

    impl Made {
        fn clip<'a>(&'a self, outputs: &'a [Tensor]) -> Clip<'a> {
            Clip { outputs, references: &self.references, motion: Some(&self.motion) }
        }
    }

    fn losses(config: &LossConfig) -> Losses {
        Losses::new(config, Device::Cpu).unwrap()
    }

    #[test]
    fn the_total_is_the_formula_of_the_paper() {
        let made = made(4);
        let config = LossConfig { flow: FlowSource::Exact, ..LossConfig::default() };
        let found = losses(&config).clip(&made.clip(&made.outputs)).unwrap();
        let measure = L1MsSsim::default();
        let l1 = |a: &Tensor, b: &Tensor| value(&(a - b).abs().mean(None));
        let (y, r) = (&made.outputs, &made.references);
        let (mut spatial, mut differences, mut flow) = (0.0, 0.0, 0.0);
        for i in 0..4 {
            let both = 0.9 * value(&measure.distance(&y[i], &r[i]).unwrap()) + 0.1 * l1(&y[i], &r[i]);
            spatial += (1.0 - (-0.5 * i as f64).exp()) * both;
            for j in 0..i {
                differences += l1(&(&y[i] - &y[j]), &(&r[i] - &r[j]));
            }
            if i > 0 {
                flow += l1(&y[i], &flow::warp(&y[i - 1], &made.motion[i]));
            }
        }
        let expected = 0.8 * spatial / 4.0 + differences / 6.0 + 0.1 * flow;
        assert!((value(&found.total) - expected).abs() < 1e-12);
        let parts = [spatial / 4.0, differences / 6.0, flow];
        for (found, expected) in [&found.spatial, &found.temporal, &found.flow].into_iter().zip(parts) {
            assert!((value(found) - expected).abs() < 1e-12);
        }
        assert_eq!(found.values().map(|(name, _)| name)[0], "total");
    }

    #[test]
    fn logarithms_make_a_hundredth_count_alike_everywhere() {
        let made = made(4);
        let config = LossConfig {
            logarithmic: true,
            l1_weight: 0.3,
            perceptual_weight: 0.0,
            squares_weight: 0.5,
            coarse_weight: 0.25,
            flow_weight: 0.0,
            spatial_weight: 1.0,
            ..LossConfig::default()
        };
        let losses = losses(&config);
        let total = |outputs: &[Tensor]| value(&losses.clip(&made.clip(outputs)).unwrap().total);
        let with_errors = |factor: f64| -> Vec<Tensor> {
            let both = made.outputs.iter().zip(&made.references);
            both.map(|(output, reference)| reference + (output - reference) * factor).collect()
        };
        // All terms but squares fall by a half.
        let expected = (0.3 + 2.0 * (0.5 + 2.0 * 0.25) + 1.0) * 0.5f64.ln();
        assert!((total(&with_errors(0.5)) - total(&made.outputs) - expected).abs() < 1e-2);
        let part = Clip { outputs: &made.outputs[..2], references: &made.references[..2], motion: None };
        let message = losses.frames(&part, 0..2, 4).unwrap_err().to_string();
        assert!(message.contains("do not add up"), "{message}");
    }

    #[test]
    fn clips_judged_together_are_judged_as_each_alone() {
        let made = made(4);
        let config = LossConfig {
            logarithmic: true,
            squares_weight: 0.5,
            coarse_weight: 0.25,
            flow: FlowSource::Exact,
            ..LossConfig::default()
        };
        let losses = losses(&config);
        let judged = |clips: [i64; 2]| {
            let of = |frames: &[Tensor]| frames.iter().map(|t| t.narrow(0, clips[0], clips[1])).collect();
            let [references, motion]: [Vec<Tensor>; 2] = [of(&made.references), of(&made.motion)];
            let outputs: Vec<Tensor> = of(&made.outputs);
            let outputs: Vec<Tensor> =
                outputs.iter().map(|output| output.copy().set_requires_grad(true)).collect();
            let clip = Clip { outputs: &outputs, references: &references, motion: Some(&motion) };
            let terms = losses.clip(&clip).unwrap();
            terms.total.backward();
            (terms.values(), outputs.iter().map(Tensor::grad).collect::<Vec<_>>())
        };
        let (together, slopes) = judged([0, 2]);
        let (alone, alone_slopes): (Vec<_>, Vec<_>) = [judged([0, 1]), judged([1, 1])].into_iter().unzip();
        assert_ne!(alone[0][0].1, alone[1][0].1);
        for (term, (name, value)) in together.into_iter().enumerate() {
            let mean = 0.5 * (alone[0][term].1 + alone[1][term].1);
            assert!((value - mean).abs() < 1e-12, "{name}: {value}, {mean}");
        }
        for (frame, slope) in slopes.iter().enumerate() {
            let both = Tensor::cat(&[0, 1].map(|clip: usize| &alone_slopes[clip][frame] * 0.5), 0);
            assert!(slope.allclose(&both, 1e-9, 1e-15, false));
        }
    }

    #[test]
    fn gradients_are_differences() {
        let made = made(4);
        for config in [
            LossConfig { flow: FlowSource::Exact, ..LossConfig::default() },
            LossConfig {
                flow: FlowSource::Exact,
                flow_confidence: Some(0.4),
                average_flow: true,
                pairs: Pairs::Adjacent,
                ..LossConfig::default()
            },
            LossConfig {
                logarithmic: true,
                squares_weight: 0.5,
                coarse_weight: 0.3,
                flow_weight: 0.0,
                ..LossConfig::default()
            },
        ] {
            let losses = losses(&config);
            let worst = worst_slope(&made.outputs, |outputs| losses.clip(&made.clip(outputs)).unwrap().total);
            assert!(worst < 1e-6, "{config:?}: {worst:e}");
        }
    }

    #[test]
    fn motion_is_searched_between_the_references() {
        let mut made = made(3);
        for source in [FlowSource::SingleLevel, FlowSource::Hierarchical] {
            let flow = |made: &Made, flow: FlowSource| {
                let config = LossConfig { flow, ..LossConfig::default() };
                value(&losses(&config).clip(&made.clip(&made.outputs)).unwrap().flow)
            };
            let found = flow(&made, source);
            let search = source.search().unwrap();
            for i in 1..3 {
                made.motion[i] = search.motion(&made.references[i], &made.references[i - 1]);
            }
            assert_eq!(found, flow(&made, FlowSource::Exact));
        }
    }

    #[test]
    fn parts_of_a_clip_add_up_with_their_gradients() {
        let made = made(5);
        let losses = losses(&LossConfig { flow: FlowSource::Exact, ..LossConfig::default() });
        let leaves = || made.outputs.iter().map(|y| y.copy().set_requires_grad(true)).collect::<Vec<_>>();
        let (whole, parts) = (leaves(), leaves());
        let total = losses.clip(&made.clip(&whole)).unwrap().total;
        total.backward();
        let mut sum = 0.0;
        for frames in [0..2, 2..4, 4..5] {
            let part = losses.frames(&made.clip(&parts[..frames.end]), frames.clone(), 5);
            // References of the whole clip are more than there are outputs.
            assert!(part.is_err() || frames.end == 5);
            let clip = Clip {
                outputs: &parts[..frames.end],
                references: &made.references[..frames.end],
                motion: Some(&made.motion),
            };
            let part = losses.frames(&clip, frames, 5).unwrap().total;
            part.backward();
            sum += value(&part);
        }
        assert!((sum - value(&total)).abs() < 1e-12);
        for (a, b) in whole.iter().zip(&parts) {
            assert!(a.grad().allclose(&b.grad(), 1e-12, 1e-14, false));
        }
    }

    #[test]
    fn what_is_wrong_is_said_with_how_to_mend_it() {
        let made = made(3);
        let losses = losses(&LossConfig { flow: FlowSource::Exact, ..LossConfig::default() });
        let without = Clip { motion: None, ..made.clip(&made.outputs) };
        let message = losses.clip(&without).unwrap_err().to_string();
        assert!(message.contains("motion of frame 1 is missing; give it"), "{message}");
        let none = Clip { outputs: &[], references: &[], motion: None };
        assert!(losses.clip(&none).is_err());
        let other = [pictures([2, 12, 15], 0.0, EXACT), made.outputs[1].copy(), made.outputs[2].copy()];
        let message = losses.clip(&made.clip(&other)).unwrap_err().to_string();
        assert!(message.contains("cannot be compared"), "{message}");
    }

    #[test]
    fn nothing_is_differentiated_where_nothing_is_asked_for() {
        let made = made(3);
        let losses = losses(&LossConfig { flow: FlowSource::Exact, ..LossConfig::default() });
        let plain = losses.clip(&made.clip(&made.outputs)).unwrap().total;
        assert!(!plain.requires_grad());
        let leaves: Vec<Tensor> = made.outputs.iter().map(|y| y.copy().set_requires_grad(true)).collect();
        let silent = tch::no_grad(|| losses.clip(&made.clip(&leaves)).unwrap().total);
        assert!(!silent.requires_grad());
        assert!((value(&silent) - value(&plain)).abs() < 1e-15);
    }

    #[test]
    fn configurations_survive_files() {
        let config =
            LossConfig { flow_confidence: Some(0.1), warm_up: WarmUp::None, ..LossConfig::default() };
        let text = toml::to_string(&config).unwrap();
        assert_eq!(toml::from_str::<LossConfig>(&text).unwrap(), config);
        assert_eq!(toml::from_str::<LossConfig>("").unwrap(), LossConfig::default());
        assert!(toml::from_str::<LossConfig>("colour = 3").is_err());
    }
}
