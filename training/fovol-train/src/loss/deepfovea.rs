//! The losses of DeepFovea (Kaplanyan et al. 2019), which FoVolNet is compared with.
//!
//! DeepFovea's generator minimises −mean(D) + 100·VGG + 20·flow, where D is a pair of discriminators that learn beside
//! it (spectrally normalised 3D convolutions over 32 frames, and over their 3D Fourier transform). For the
//! comparison the authors of FoVolNet trained the architecture "in our training pipeline using hyperparameters as
//! suggested by the authors"; their public code has no discriminator there, and VGG + 0.1·flow. So nothing here is
//! adversarial: [`LossConfig::deepfovea_fvn`] is the loss of that code, [`LossConfig::deepfovea`] what remains of the
//! published one without D.

use super::{FlowSource, LossConfig, Pairs, PerceptualConfig, WarmUp};

/// The weights of the first frames of a clip in DeepFovea's own graph; later frames count 1.
pub const FRAME_WEIGHTS: [f64; 10] = [1e-5, 5e-5, 1e-4, 5e-4, 1e-3, 5e-3, 0.01, 0.05, 0.1, 0.5];
/// The weights of the perceptual term and of flow in DeepFovea's graph.
const WEIGHTS: [f64; 2] = [100.0, 20.0];
/// Pixels whose references differ by more than this along the motion do not count.
const CONFIDENT: f64 = 0.1;
/// DeepFovea's pictures are −1…1, so that all differences are twice as large as here.
const RANGE: f64 = 2.0;

impl LossConfig {
    /// What the authors of FoVolNet trained DeepFovea with: 1/T · Σ_i `perceptual` + 0.1 · Σ_i |y_i − warp(y_{i−1})|,
    /// along the motion that block matching finds. Their measure is [`PerceptualConfig::FovolnetVgg`].
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

    /// DeepFovea's generator loss without its discriminators: 100/T · Σ_i w_i · `perceptual` + 20/(T − 1) · Σ_i of the
    /// mean |y_i − warp(y_{i−1})| of pixels that can be followed, in pictures of −1…1; w_i are [`FRAME_WEIGHTS`].
    /// Its measure is [`PerceptualConfig::DeepfoveaVgg`].
    ///
    /// That sums over frames are means is an assumption: the graph does not say what it was run on.
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
