use super::{FlowSource, Pairs, PerceptualConfig, WarmUp};
use serde::{Deserialize, Serialize};

/// What a loss is made of.
///
/// The default is the paper's with the perceptual measure that needs no weights. In a file, what is not said is as
/// in the paper:
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
    /// λ_s, of all that compares single frames.
    pub spatial_weight: f64,
    /// λ_t, of all that compares frames with each other.
    pub temporal_weight: f64,
    /// λ₁, of the perceptual measure.
    pub perceptual_weight: f64,
    /// λ₂, of the mean absolute difference.
    pub l1_weight: f64,
    /// Of the mean squared difference, of which the paper has none.
    pub squares_weight: f64,
    /// Of the mean squared differences of means over 4×4, and over 16×16 pixels, each.
    pub coarse_weight: f64,
    /// λ₃, of differences between frames.
    pub difference_weight: f64,
    /// λ₄, of optical flow.
    pub flow_weight: f64,
    /// Weights of the frames in what compares single frames.
    pub warm_up: WarmUp,
    /// Frames whose differences are compared.
    pub pairs: Pairs,
    /// Where the motion comes from.
    pub flow: FlowSource,
    /// Pixels count only where the references agree along the motion: their absolute differences, summed over red,
    /// green and blue, are below this. Not given: all pixels count.
    pub flow_confidence: Option<f64>,
    /// Whether the term of optical flow is divided by the number of steps, T − 1, as the others are.
    pub average_flow: bool,
    /// Whether the logarithms of the terms are added instead of the terms: then a hundredth less counts alike in clips
    /// with large and with small errors, as in decibels. Gradients have to go back over whole clips; clips of a batch
    /// are averaged before.
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
