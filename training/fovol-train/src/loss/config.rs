use super::{FlowSource, Pairs, PerceptualConfig, WarmUp};
use serde::{Deserialize, Serialize};

/// Terms and weights of a loss.
///
/// The default is the paper's loss with a perceptual measure that needs no weights. Fields that a file leaves out
/// have the paper's values:
///
/// ```
/// use fovol_train::loss::{FlowSource, LossConfig};
///
/// let config: LossConfig = toml::from_str(
///     r#"
///     flow = "exact"
///     flow-confidence = 0.1
///     pairs = "adjacent"
///     warm-up = { exponential = 0.5 }
///     perceptual = { measure = "l1-ms-ssim", gradient = 0.1 }
///     "#,
/// )?;
/// assert_eq!(config.flow, FlowSource::Exact);
/// assert_eq!(config.spatial_weight, 0.8);
/// # Ok::<(), toml::de::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, rename_all = "kebab-case", deny_unknown_fields)]
pub struct LossConfig {
    /// λ_s, weight of the terms of single frames.
    pub spatial_weight: f64,
    /// λ_t, weight of the terms between frames.
    pub temporal_weight: f64,
    /// λ₁, weight of the perceptual measure.
    pub perceptual_weight: f64,
    /// λ₂, weight of the mean absolute difference.
    pub l1_weight: f64,
    /// Weight of the mean squared difference. The paper has no such term.
    pub squares_weight: f64,
    /// Weight of each mean squared difference of averages, over 4×4 and over 16×16 pixels.
    pub coarse_weight: f64,
    /// λ₃, weight of the differences between frames.
    pub difference_weight: f64,
    /// λ₄, weight of the optical flow term.
    pub flow_weight: f64,
    /// Weights of the frames in the terms of single frames.
    pub warm_up: WarmUp,
    /// Pairs of frames whose differences are compared.
    pub pairs: Pairs,
    /// Source of the motion.
    pub flow: FlowSource,
    /// Threshold of confident pixels. A pixel counts only where the references' absolute differences along the
    /// motion, summed over RGB, stay below it. `None` counts all pixels.
    pub flow_confidence: Option<f64>,
    /// Whether the optical flow term is divided by the number of steps, T − 1, like the other terms.
    pub average_flow: bool,
    /// Whether logarithms of the terms are added. A reduction by one per cent then counts equally in clips with large
    /// and with small errors, as in decibels. Requires gradients over whole clips.
    pub logarithmic: bool,
    /// The perceptual measure.
    pub perceptual: PerceptualConfig,
}

impl Default for LossConfig {
    fn default() -> Self {
        Self {
            spatial_weight: 0.8,
            temporal_weight: 1.0,
            perceptual_weight: 0.9,
            l1_weight: 0.1,
            squares_weight: 0.0,
            coarse_weight: 0.0,
            difference_weight: 1.0,
            flow_weight: 0.1,
            warm_up: WarmUp::Exponential(0.5),
            pairs: Pairs::All,
            flow: FlowSource::SingleLevel,
            flow_confidence: None,
            average_flow: false,
            logarithmic: false,
            perceptual: PerceptualConfig::default(),
        }
    }
}
