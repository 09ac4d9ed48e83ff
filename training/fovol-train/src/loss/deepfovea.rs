//! Losses of DeepFovea (Kaplanyan et al. 2019), the method that FoVolNet is compared with.
//!
//! DeepFovea's generator minimises −mean(D) + 100·VGG + 20·flow. D is a pair of discriminators trained beside it:
//! spectrally normalised 3D convolutions over 32 frames, and over their 3D Fourier transform. For the comparison,
//! FoVolNet's authors trained the architecture "in our training pipeline using hyperparameters as suggested by the
//! authors". Their public code has no discriminator there, and minimises VGG + 0.1·flow. So nothing here is
//! adversarial. [`LossConfig::deepfovea_fvn`] is the loss of that code; [`LossConfig::deepfovea`] is the published
//! loss without D.

pub use super::spatial::FRAME_WEIGHTS;

use super::{FlowSource, LossConfig, Pairs, PerceptualConfig, WarmUp};

/// Weights of the perceptual and the flow term in DeepFovea's graph.
const WEIGHTS: [f64; 2] = [100.0, 20.0];
/// Confidence threshold: pixels whose references differ by more than this along the motion do not count.
const CONFIDENT: f64 = 0.1;
/// DeepFovea's pictures range over −1…1, so that differences are twice as large as here.
const RANGE: f64 = 2.0;

impl LossConfig {
    /// The loss with which FoVolNet's authors trained DeepFovea: 1/T · Σ_i `perceptual` + 0.1 · Σ_i |y_i −
    /// warp(y_{i−1})|. Block matching finds the motion. Their measure is [`PerceptualConfig::FovolnetVgg`].
    pub fn deepfovea_fvn(perceptual: PerceptualConfig) -> Self {
        Self {
            spatial_weight: 1.0,
            temporal_weight: 1.0,
            perceptual_weight: 1.0,
            l1_weight: 0.0,
            squares_weight: 0.0,
            coarse_weight: 0.0,
            difference_weight: 0.0,
            flow_weight: 0.1,
            warm_up: WarmUp::None,
            pairs: Pairs::Adjacent,
            flow: FlowSource::SingleLevel,
            flow_confidence: None,
            average_flow: false,
            logarithmic: false,
            perceptual,
        }
    }

    /// DeepFovea's generator loss without its discriminators. It is 100/T · Σ_i w_i · `perceptual` + 20/(T − 1) · Σ_i
    /// mean |y_i − warp(y_{i−1})| over confident pixels, in pictures of −1…1. The w_i are [`FRAME_WEIGHTS`].
    /// DeepFovea's own measure is [`PerceptualConfig::DeepfoveaVgg`].
    ///
    /// Averaging over frames is an assumption: the published graph does not show the clip length.
    pub fn deepfovea(perceptual: PerceptualConfig, flow: FlowSource) -> Self {
        Self {
            spatial_weight: WEIGHTS[0],
            temporal_weight: 1.0,
            perceptual_weight: 1.0,
            l1_weight: 0.0,
            squares_weight: 0.0,
            coarse_weight: 0.0,
            difference_weight: 0.0,
            flow_weight: WEIGHTS[1] * RANGE,
            warm_up: WarmUp::Deepfovea,
            pairs: Pairs::Adjacent,
            flow,
            flow_confidence: Some(CONFIDENT / RANGE),
            average_flow: true,
            logarithmic: false,
            perceptual,
        }
    }
}
