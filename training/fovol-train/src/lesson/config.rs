use crate::mask_noise::NoiseConfig;
use serde::{Deserialize, Serialize};

/// Augmentation and sampling of clips.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct LessonConfig {
    /// Lowest and highest base density; drawn log-uniformly.
    pub base: [f64; 2],
    /// Lowest and highest standard deviation of the fovea, in pixels.
    pub sigma: [f64; 2],
    /// Probability of a mask without a fovea.
    pub without_fovea: f64,
    /// Probability of a clip whose light ratios are learned, not its colours: docs/guide/src/internals/algorithm.md,
    /// section 5.1.
    pub guide: f64,
    /// Probability of a mask whose density follows the last frame: docs/guide/src/internals/algorithm.md, section 1.1.
    pub adaptive: f64,
    /// Probabilities of augmentations.
    pub augment: Augment,
    /// Noise of the masks.
    pub noise: NoiseConfig,
}

/// Probabilities of augmentations, by default those of Table 2 of the paper.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct Augment {
    /// Permutation of the colour channels.
    pub colours: f64,
    /// Horizontal flip.
    pub flip_horizontal: f64,
    /// Vertical flip.
    pub flip_vertical: f64,
    /// Conversion to grey.
    pub grey: f64,
    /// Freezing the clip at a frame.
    pub still: f64,
    /// Blanking a border of up to [`MOST_PADDING`] pixels.
    pub padding: f64,
}

/// Largest width of the blank border, in pixels.
pub const MOST_PADDING: u32 = 32;

impl Augment {
    /// No augmentation.
    pub const NONE: Self =
        Self { colours: 0.0, flip_horizontal: 0.0, flip_vertical: 0.0, grey: 0.0, still: 0.0, padding: 0.0 };
}

impl Default for LessonConfig {
    fn default() -> Self {
        Self {
            base: [0.008, 0.12],
            sigma: [10.0, 60.0],
            without_fovea: 0.3,
            guide: 0.0,
            adaptive: 0.0,
            augment: Augment::default(),
            noise: NoiseConfig::default(),
        }
    }
}

impl Default for Augment {
    fn default() -> Self {
        Self { colours: 0.6, flip_horizontal: 0.5, flip_vertical: 0.5, grey: 0.3, still: 0.3, padding: 0.1 }
    }
}
