use crate::plan::layers::{Normalisation, Taps};
use serde::{Deserialize, Serialize};

/// Picture of the last frame that is an input of the U-Net. See docs/guide/src/internals/algorithm.md, sections 4.1
/// and 4.3.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Feedback {
    /// No picture.
    None,
    /// The direct prediction, as in the paper.
    Direct,
    /// The output, clamped to 0…1, so that feedback cannot diverge.
    Output,
}

/// Options of a [`WNetConfig`](super::WNetConfig).
#[derive(Debug, Clone, PartialEq)]
pub struct WNetOptions {
    /// Channels of the encoders, finest first. The last one is the bottleneck.
    pub encoder: Vec<usize>,
    /// Channels of the decoders, finest first: one fewer than encoders.
    pub decoder: Vec<usize>,
    /// Whether decoders read their own output of the last frame.
    pub recurrent: bool,
    /// Whether the U-Net works at half the resolution, with 2×2 pixels folded into channels.
    pub fold: bool,
    /// Whether the sample mask is an input of the U-Net. With [`Accumulation`] the weights of the samples take its
    /// place.
    pub mask: bool,
    /// Whether the output takes sampled pixels unchanged.
    pub bypass: bool,
    /// Whether states of the last frame are moved along the renderer's motion.
    pub reproject: bool,
    /// Picture of the last frame that is an input of the U-Net.
    pub feedback: Feedback,
    /// Filling of unsampled pixels before the U-Net runs. Without it the U-Net reads the sampled pixels alone.
    pub fill: Option<Fill>,
    /// Output of the network.
    pub prediction: Prediction,
}

/// Filling of unsampled pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fill {
    /// Number of times that the filled picture is smoothed and then corrected by its residuals at the samples: 0 to
    /// 8. Further corrections make no visible difference.
    pub corrections: u32,
    /// Samples of earlier frames that the picture is filled from. Without them it is filled from the samples of its
    /// own frame alone.
    pub accumulation: Option<Accumulation>,
}

/// Accumulation of the samples of earlier frames.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Accumulation {
    /// Weight that earlier samples keep from one frame to the next: above 0, at most 1.
    pub weight: f32,
    /// Whether samples are points, each with its offset within its pixel. Points move without interpolation, so
    /// repeated motion does not blur them. Needs [`WNetOptions::reproject`].
    pub points: bool,
    /// Second picture, filled from the samples of this frame alone. Accumulated samples are wrong where the motion
    /// is wrong, and this picture is not.
    pub fresh: Option<Fresh>,
}

/// Picture that is filled from the samples of one frame. The U-Net reads it, and [`Kernels`] weigh it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Fresh {
    /// Taps of K's last kernel in the picture.
    pub taps: Taps,
    /// Whether the picture is corrected at most once and stays at half the resolution, so that it is never written
    /// at full resolution. The U-Net reads it unchanged, K bilinearly. Needs [`WNetOptions::fold`] and
    /// [`WNetOptions::bypass`].
    pub coarse: bool,
    /// Whether accumulated samples lose weight where the samples of this frame contradict the last output, because
    /// the motion is wrong or a surface comes into view. Needs the last output: [`Kernels::history`] or a
    /// [`Feedback`].
    pub history_confidence: bool,
}

/// Output of a network.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Prediction {
    /// The picture that the U-Net predicts (D).
    Direct(Direct),
    /// A picture filtered by kernels (K), which are predicted from features of the U-Net.
    Kernels(Kernels),
}

/// Picture that the U-Net predicts (D).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Direct {
    /// Whether the layer that predicts the picture also reads the filled picture, so that it can learn a residual.
    /// Needs [`WNetOptions::fill`].
    pub residual: bool,
}

/// Kernels that filter pictures (K).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Kernels {
    /// Normalisation of the weights.
    pub normalisation: Normalisation,
    /// Resolutions at which pictures are filtered, and the direct prediction among them.
    pub filtering: Filtering,
    /// Taps of the last kernel in the last output, if it weighs that.
    pub history: Option<Taps>,
    /// Taps of the last kernel in the filled picture, if it weighs that. Needs [`WNetOptions::fill`].
    pub filled: Option<Taps>,
    /// Whether a picture that the U-Net predicts is added to the result. Kernels alone can only average their
    /// inputs.
    pub addition: bool,
}

/// Resolutions at which kernels filter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Filtering {
    /// Once, at the finest resolution: the direct prediction with these taps, if there is one, and the other
    /// pictures that are weighed.
    Once {
        /// Direct prediction and its taps.
        direct: Option<(Direct, Taps)>,
    },
    /// At every resolution, down and up again. The kernels filter the direct prediction, or without one the sampled
    /// or filled picture.
    EveryLevel {
        /// Direct prediction.
        direct: Option<Direct>,
    },
}

/// Upper limit of [`Fill::corrections`].
const MOST_CORRECTIONS: u32 = 8;

impl WNetOptions {
    /// Kernels, if the network has them.
    pub fn kernels(&self) -> Option<Kernels> {
        match self.prediction {
            Prediction::Direct(_) => None,
            Prediction::Kernels(kernels) => Some(kernels),
        }
    }

    /// Direct prediction, if the network makes one.
    pub fn direct(&self) -> Option<Direct> {
        match self.prediction {
            Prediction::Direct(direct) => Some(direct),
            Prediction::Kernels(kernels) => match kernels.filtering {
                Filtering::Once { direct } => direct.map(|(direct, _)| direct),
                Filtering::EveryLevel { direct } => direct,
            },
        }
    }

    /// Accumulation of earlier samples, if the network accumulates them.
    pub fn accumulation(&self) -> Option<Accumulation> {
        self.fill?.accumulation
    }

    /// Picture of the samples of one frame, if earlier samples are accumulated and the network reads this one too.
    pub fn fresh(&self) -> Option<Fresh> {
        self.accumulation()?.fresh
    }

    /// Whether the network reads the output of the last frame.
    pub fn reads_last(&self) -> bool {
        self.feedback != Feedback::None || self.kernels().is_some_and(|kernels| kernels.history.is_some())
    }

    /// Checks numbers, and options that need others.
    ///
    /// # Errors
    /// Options that do not fit together, in one line.
    pub(super) fn check(&self) -> Result<(), String> {
        self.check_widths()?;
        check_corrections(self.fill.map_or(0, |fill| fill.corrections))?;
        let weight = self.accumulation().map_or(1.0, |accumulation| accumulation.weight);
        if !(weight > 0.0 && weight <= 1.0) {
            return Err(format!("`accumulate` is {weight}, a weight; give 0 to 1"));
        }
        let missing = self.missing().into_iter().find(|(is_missing, _)| *is_missing);
        missing.map_or(Ok(()), |(_, problem)| Err(problem.into()))
    }

    fn check_widths(&self) -> Result<(), String> {
        let (encoders, decoders) = (self.encoder.len(), self.decoder.len());
        if !(2..=8).contains(&encoders) || decoders + 1 != encoders {
            return Err(format!(
                "{encoders} encoders and {decoders} decoders do not make a U-Net; give 2 to 8 encoders and one \
                 decoder fewer"
            ));
        }
        if self.encoder.iter().chain(&self.decoder).any(|&width| width == 0 || width > 4096) {
            return Err("a layer of the network has no channels or more than 4096".into());
        }
        Ok(())
    }

    /// For each option that needs another one, whether that is missing, and how to mend it.
    fn missing(&self) -> [(bool, &'static str); 8] {
        let (kernels, fresh, direct) = (self.kernels(), self.fresh(), self.direct());
        let filled = kernels.and_then(|kernels| kernels.filled);
        let is_once = |kernels: Kernels| matches!(kernels.filtering, Filtering::Once { .. });
        let weighs = [kernels.and_then(|kernels| kernels.history), filled, fresh.map(|fresh| fresh.taps)];
        [
            (
                filled.is_some() && self.fill.is_none(),
                "there is no filled picture to weigh; set `prefill`, or leave out `filled`",
            ),
            (
                direct.is_some_and(|direct| direct.residual) && self.fill.is_none(),
                "there is no filled picture to add to; set `prefill`, or leave out `residual`",
            ),
            (self.accumulation().is_some_and(|accumulation| accumulation.points) && !self.reproject, POINTS),
            (fresh.is_some() && kernels.is_none(), TAPS),
            (
                fresh.is_some_and(|fresh| fresh.history_confidence) && !self.reads_last(),
                "the last picture is needed to doubt what it was made of; set `history` or `feedback`, or leave out \
                 `doubt`",
            ),
            (fresh.is_some_and(|fresh| fresh.coarse) && !(self.fold && self.bypass), COARSE),
            (self.feedback == Feedback::Direct && direct.is_none(), DIRECT),
            (
                direct.is_none() && kernels.is_some_and(is_once) && weighs.iter().all(Option::is_none),
                "`flat` kernels need a picture to weigh; set `filled`, `fresh`, `history` or `direct`",
            ),
        ]
    }
}

/// Checks the number of corrections of a filled picture.
pub(super) fn check_corrections(corrections: u32) -> Result<(), String> {
    match corrections <= MOST_CORRECTIONS {
        true => Ok(()),
        false => Err(format!("`corrections` is {corrections}; give 0 to {MOST_CORRECTIONS}")),
    }
}

/// Message for points that are not accumulated or not moved.
pub(super) const POINTS: &str = "`points` are samples that are accumulated and moved; set `accumulate` and \
                                 `reproject`, or leave out `points`";
/// Message for taps of kernels that are missing.
pub(super) const TAPS: &str =
    "taps for K need kernels; set `kernels`, or leave out `history`, `filled`, `flat` and `fresh`";
/// Message for a coarse picture where it cannot be used.
pub(super) const COARSE: &str =
    "`coarse` needs a `fresh` picture, `fold` and `bypass`; set these, or leave out `coarse`";
/// Message for a direct prediction that is missing.
pub(super) const DIRECT: &str = "without a direct prediction there must be `kernels`, and neither `residual` nor \
                                 direct `feedback`; set these, or leave out `direct`";
