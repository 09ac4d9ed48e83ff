mod walk;

use super::Plan;
use super::layer::{Normalisation, Taps};
use serde::{Deserialize, Serialize};
use walk::Walk;

/// Which picture of the last frame comes back in as input (ALGORITHMS §9.7).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Feedback {
    /// None.
    None,
    /// The direct prediction O_d, as in the paper.
    Direct,
    /// The output, cut to 0…1: then what is fed back cannot grow without end.
    Output,
}

/// Corrections beyond this change nothing that can be seen.
const MOST_CORRECTIONS: u32 = 8;

/// A U-Net whose decoders may be recurrent, which predicts the picture directly (D) and then filters it with
/// predicted kernels (K): FoVolNet, its relatives, and with `kernels` off what it was compared with.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct WNetConfig {
    /// Channels of the encoders, finest first; the last is the bottleneck.
    pub encoder: Vec<usize>,
    /// Channels of the decoders, finest first: one fewer than encoders.
    pub decoder: Vec<usize>,
    /// What comes back in.
    pub feedback: Feedback,
    /// Whether K follows D.
    pub kernels: bool,
    /// How its kernels are normalised.
    pub normalisation: Normalisation,
    /// Whether the U-Net works on 2×2 pixels as one with four times the channels.
    pub fold: bool,
    /// Whether the U-Net is told which pixels were sampled.
    pub mask: bool,
    /// Whether unsampled pixels are filled before.
    pub prefill: bool,
    /// Whether sampled pixels reach the output as they are.
    pub bypass: bool,
    /// What K's last kernel weighs of the last output.
    #[serde(default)]
    pub history: Option<Taps>,
    /// Whether what comes from the last frame is moved along the renderer's motion.
    pub reproject: bool,
    /// What K's last kernel weighs of the filled picture.
    #[serde(default)]
    pub filled: Option<Taps>,
    /// What K's only kernel weighs of the direct prediction, if it is to filter once, at the finest resolution. Without
    /// it K filters at every resolution, down and up again.
    #[serde(default)]
    pub flat: Option<Taps>,
    /// The weight that a sample keeps from frame to frame in the filled picture, 0…1: with 0 it is filled from the
    /// samples of its frame alone. The U-Net is then told these weights for the mask.
    #[serde(default)]
    pub accumulate: f32,
    /// Whether accumulated samples are points, moved whole and each with its place in its pixel, so that no picture of them
    /// is interpolated again and again; needs `reproject`.
    #[serde(default)]
    pub points: bool,
    /// What K's last kernel weighs of a second picture, filled from the samples of its frame alone, which the U-Net is
    /// shown too: what was accumulated is wrong where the motion is.
    #[serde(default)]
    pub fresh: Option<Taps>,
    /// Whether that second picture is corrected at most once, and read at half the resolution, at which it is spread, so that it
    /// is never written at the full one: by the U-Net as it is, by K bilinear, to which it is the same where nothing was
    /// sampled; needs `fold` and `bypass`.
    #[serde(default)]
    pub coarse: bool,
    /// Whether accumulated samples lose weight where those of the frame contradict the last picture, as they do where the
    /// motion is wrong or something comes to light; needs `fresh`, and `history` or `feedback`.
    #[serde(default)]
    pub doubt: bool,
    /// How often what is filled is smoothed and then corrected by what the samples differ from it.
    #[serde(default)]
    pub corrections: u32,
    /// Whether the direct prediction also reads the filled picture: then it can begin as that, and learn what to add.
    #[serde(default)]
    pub residual: bool,
    /// Whether what the U-Net predicts besides is added to what K makes: K alone can only average its images.
    #[serde(default)]
    pub addition: bool,
    /// Whether decoders read what they wrote for the last frame.
    #[serde(default = "yes")]
    pub recurrent: bool,
    /// Whether D predicts a picture. Without one, K's only kernel weighs the other pictures alone; kernels at every
    /// resolution filter what was sampled.
    #[serde(default = "yes")]
    pub direct: bool,
}

fn yes() -> bool {
    true
}

impl WNetConfig {
    /// Encoders 64-64-80-96 and decoders 80-64-64 (ALGORITHMS §1.2, paper widths).
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

    /// The same with 32 channels in the last decoder (the release's "small").
    pub fn narrow() -> Self {
        Self { decoder: vec![32, 64, 80], ..Self::paper() }
    }

    /// Ours.
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

    /// `temporal_unet` of the FoVolNet release, which the paper calls DeepFovea.
    pub fn deepfovea() -> Self {
        Self {
            encoder: vec![32, 64, 128, 128, 128],
            decoder: vec![32, 64, 128, 128],
            feedback: Feedback::None,
            kernels: false,
            ..Self::paper()
        }
    }

    /// Its plan.
    ///
    /// # Errors
    /// Widths that do not fit together.
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
