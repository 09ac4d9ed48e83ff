use fovol_core::did_you_mean;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// Distribution of the samples of a frame away from the gaze.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Density {
    /// Equal everywhere, as in the paper.
    Fixed,
    /// More where the last frame changes from pixel to pixel, and none where nothing can be seen; as many in all.
    Adaptive,
}

impl Density {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Fixed, Self::Adaptive];

    /// Name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Fixed => "fixed",
            Self::Adaptive => "adaptive",
        }
    }
}

impl fmt::Display for Density {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Density {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Self::ALL.into_iter().find(|density| density.name().eq_ignore_ascii_case(text)).ok_or_else(|| {
            let meant = did_you_mean(text, &["auto", "fixed", "adaptive"]);
            format!("`{text}` is no density; use auto, fixed or adaptive{meant}")
        })
    }
}
