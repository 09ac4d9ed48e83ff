mod walk;

use super::definition::Plan;
use super::layers::{Normalisation, Taps};
use serde::{Deserialize, Serialize};
use walk::Walk;

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

/// Upper limit of [`WNetConfig::corrections`]. Further corrections make no visible difference.
const MOST_CORRECTIONS: u32 = 8;

/// Configuration of a U-Net that predicts a picture (D), and of kernels that filter it (K).
///
/// It describes FoVolNet and its variants. Without `kernels` it describes the network that the FoVolNet paper calls
/// DeepFovea.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct WNetConfig {
    /// Channels of the encoders, finest first. The last one is the bottleneck.
    pub encoder: Vec<usize>,
    /// Channels of the decoders, finest first: one fewer than encoders.
    pub decoder: Vec<usize>,
    /// Picture of the last frame that is an input of the U-Net.
    pub feedback: Feedback,
    /// Whether kernels (K) filter the direct prediction (D).
    pub kernels: bool,
    /// Normalisation of the kernel weights.
    pub normalisation: Normalisation,
    /// Whether the U-Net works at half the resolution, with 2×2 pixels folded into channels.
    pub fold: bool,
    /// Whether the sample mask is an input of the U-Net.
    pub mask: bool,
    /// Whether unsampled pixels are filled before the U-Net runs.
    pub prefill: bool,
    /// Whether the output takes sampled pixels unchanged.
    pub bypass: bool,
    /// Taps of K's last kernel in the last output, if it weighs that.
    #[serde(default)]
    pub history: Option<Taps>,
    /// Whether states of the last frame are moved along the renderer's motion.
    pub reproject: bool,
    /// Taps of K's last kernel in the filled picture, if it weighs that.
    #[serde(default)]
    pub filled: Option<Taps>,
    /// Taps of K's only kernel in the direct prediction, for a K that filters once, at the finest resolution. With
    /// `None` K filters at every resolution, down and up again.
    #[serde(default)]
    pub flat: Option<Taps>,
    /// Weight, 0…1, that earlier samples keep from one frame to the next in the filled picture. With 0 the picture
    /// is filled from the samples of its own frame alone. The U-Net reads these weights in place of the mask.
    #[serde(default)]
    pub accumulate: f32,
    /// Whether accumulated samples are points, each with its offset within its pixel. Points move without
    /// interpolation, so repeated motion does not blur them. Needs `reproject`.
    #[serde(default)]
    pub points: bool,
    /// Taps of K's last kernel in a second picture, filled from the samples of this frame alone; the U-Net reads it
    /// too. Accumulated samples are wrong where the motion is wrong, and this picture is not.
    #[serde(default)]
    pub fresh: Option<Taps>,
    /// Whether the second picture (`fresh`) is corrected at most once and stays at half the resolution, so that it
    /// is never written at full resolution. The U-Net reads it unchanged, K bilinearly. Needs `fold` and `bypass`.
    #[serde(default)]
    pub coarse: bool,
    /// Whether accumulated samples lose weight where the samples of this frame contradict the last output, because
    /// the motion is wrong or a surface comes into view. Needs `fresh`, and `history` or `feedback`.
    #[serde(default)]
    pub doubt: bool,
    /// Number of times that the filled picture is smoothed and then corrected by its residuals at the samples.
    #[serde(default)]
    pub corrections: u32,
    /// Whether the layer that makes the direct prediction also reads the filled picture, so that it can learn a
    /// residual.
    #[serde(default)]
    pub residual: bool,
    /// Whether a picture that the U-Net predicts is added to K's result. K alone can only average its inputs.
    #[serde(default)]
    pub addition: bool,
    /// Whether decoders read their own output of the last frame.
    #[serde(default = "yes")]
    pub recurrent: bool,
    /// Whether D predicts a picture. Without one, a single kernel (`flat`) weighs only the other pictures, and
    /// kernels at every resolution filter the sampled or filled picture.
    #[serde(default = "yes")]
    pub direct: bool,
}

fn yes() -> bool {
    true
}

impl WNetConfig {
    /// Configuration with the widths of the paper: docs/guide/src/internals/algorithm.md, section 4.1.
    pub fn paper() -> Self {
        Self {
            encoder: vec![64, 64, 80, 96],
            decoder: vec![64, 64, 80],
            feedback: Feedback::Direct,
            kernels: true,
            normalisation: Normalisation::Squared,
            fold: false,
            mask: false,
            prefill: false,
            bypass: false,
            history: None,
            reproject: false,
            filled: None,
            flat: None,
            accumulate: 0.0,
            points: false,
            fresh: None,
            coarse: false,
            doubt: false,
            corrections: 0,
            residual: false,
            addition: false,
            recurrent: true,
            direct: true,
        }
    }

    /// Configuration of the paper with 32 channels in the last decoder (the authors' release: "small").
    pub fn narrow() -> Self {
        Self { decoder: vec![32, 64, 80], ..Self::paper() }
    }

    /// Configuration of `wnet-fast`: docs/guide/src/internals/algorithm.md, section 5.
    pub fn fast() -> Self {
        Self {
            encoder: vec![16, 16, 32, 48],
            decoder: vec![16, 16, 32],
            feedback: Feedback::Output,
            kernels: true,
            normalisation: Normalisation::Squared,
            fold: true,
            mask: true,
            prefill: true,
            bypass: true,
            history: Some(Taps::Centre),
            reproject: true,
            filled: Some(Taps::Around),
            flat: Some(Taps::Centre),
            accumulate: 0.98,
            points: true,
            fresh: Some(Taps::Centre),
            coarse: true,
            doubt: true,
            corrections: 1,
            residual: false,
            addition: true,
            recurrent: false,
            direct: false,
        }
    }

    /// Configuration of `temporal_unet` in the authors' release, which the paper calls DeepFovea.
    pub fn deepfovea() -> Self {
        Self {
            encoder: vec![32, 64, 128, 128, 128],
            decoder: vec![32, 64, 128, 128],
            feedback: Feedback::None,
            kernels: false,
            ..Self::paper()
        }
    }

    /// Builds the plan of the network.
    ///
    /// # Errors
    /// Widths or options that do not fit together.
    pub fn plan(&self) -> Result<Plan, String> {
        self.check()?;
        Ok(Walk::new(self).run())
    }

    fn check(&self) -> Result<(), String> {
        let widths = self.encoder.iter().chain(&self.decoder);
        if self.encoder.len() < 2 || self.encoder.len() > 8 || self.decoder.len() + 1 != self.encoder.len() {
            return Err(format!(
                "{} encoders and {} decoders do not make a U-Net; give 2 to 8 encoders and one decoder fewer",
                self.encoder.len(),
                self.decoder.len()
            ));
        }
        if widths.clone().any(|&width| width == 0 || width > 4096) {
            return Err("a layer of the network has no channels or more than 4096".into());
        }
        let taps = [self.history, self.filled, self.flat, self.fresh];
        if taps.iter().any(Option::is_some) && !self.kernels {
            return Err(
                "taps for K need kernels; set `kernels`, or leave out `history`, `filled`, `flat` and `fresh`".into(),
            );
        }
        if self.filled.is_some() && !self.prefill {
            return Err("there is no filled picture to weigh; set `prefill`, or leave out `filled`".into());
        }
        if !(0.0..=1.0).contains(&self.accumulate) {
            return Err(format!("`accumulate` is {}, a weight; give 0 to 1", self.accumulate));
        }
        if self.accumulate > 0.0 && !self.prefill {
            return Err(
                "samples are accumulated to be filled; set `prefill`, or leave out `accumulate`".into()
            );
        }
        if self.points && (self.accumulate == 0.0 || !self.reproject) {
            return Err(
                "`points` are samples that are accumulated and moved; set `accumulate` and `reproject`, or leave out \
                        `points`"
                    .into(),
            );
        }
        if self.doubt && self.fresh.is_none() {
            return Err(
                "a fresh picture is needed to doubt the others; set `fresh`, or leave out `doubt`".into()
            );
        }
        if self.doubt && self.history.is_none() && self.feedback == Feedback::None {
            return Err(
                "the last picture is needed to doubt what it was made of; set `history` or `feedback`, or leave out `doubt`"
                    .into(),
            );
        }
        if self.coarse && (self.fresh.is_none() || !self.fold || !self.bypass) {
            return Err(
                "`coarse` needs a `fresh` picture, `fold` and `bypass`; set these, or leave out `coarse`"
                    .into(),
            );
        }
        if self.corrections > MOST_CORRECTIONS {
            return Err(format!("`corrections` is {}; give 0 to {MOST_CORRECTIONS}", self.corrections));
        }
        if self.residual && !self.prefill {
            return Err("there is no filled picture to add to; set `prefill`, or leave out `residual`".into());
        }
        if self.addition && !self.kernels {
            return Err("there is nothing of K to add to; set `kernels`, or leave out `addition`".into());
        }
        if !self.direct && (!self.kernels || self.residual || self.feedback == Feedback::Direct) {
            return Err(
                "without a direct prediction there must be `kernels`, and neither `residual` nor direct \
                        `feedback`; set these, or leave out `direct`"
                    .into(),
            );
        }
        let weighs = [self.history, self.filled, self.fresh].iter().any(Option::is_some);
        if !self.direct && self.flat.is_some() && !weighs {
            return Err(
                "`flat` kernels need a picture to weigh; set `filled`, `fresh`, `history` or `direct`".into(),
            );
        }
        if self.fresh.is_some() && self.accumulate == 0.0 {
            return Err("every filled picture is fresh; set `accumulate`, or leave out `fresh`".into());
        }
        Ok(())
    }
}
