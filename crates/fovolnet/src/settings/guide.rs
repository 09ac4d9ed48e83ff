use crate::guide::GuideGrid;
use fovol_core::{FrameSize, Region, did_you_mean};
use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// Pixels that are marched without shadow rays, as a guide for the light ratio.
///
/// With a guide, only the ratio of the colour to the guide is reconstructed from sparse samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Guide {
    /// None: colours are reconstructed, as in the paper.
    None,
    /// At most a quarter of the pixels, where the picture without shadows has most detail; others in the next frames.
    Quarter,
    /// Every pixel.
    Full,
    /// Pixels as in [`Self::Quarter`], with cached shadows: better where light and transfer function rest for some frames.
    Cached,
}

impl Guide {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::None, Self::Quarter, Self::Full, Self::Cached];

    /// Coarsest level of the guide of frame number `index`, of `size`, in `region`; `None` without a guide.
    pub(crate) fn grid(self, index: u32, region: Region, size: FrameSize) -> Option<GuideGrid> {
        match self {
            Self::None => None,
            Self::Quarter | Self::Cached => Some(GuideGrid::coarsest(index, region, size)),
            Self::Full => Some(GuideGrid::every_pixel(region, size)),
        }
    }

    /// Name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Quarter => "quarter",
            Self::Full => "full",
            Self::Cached => "cached",
        }
    }
}

impl fmt::Display for Guide {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Guide {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Self::ALL.into_iter().find(|guide| guide.name().eq_ignore_ascii_case(text)).ok_or_else(|| {
            let meant = did_you_mean(text, &["auto", "none", "quarter", "full", "cached"]);
            format!("`{text}` is no guide; use auto, none, quarter, full or cached{meant}")
        })
    }
}
