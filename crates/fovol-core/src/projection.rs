use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// How a camera projects.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Projection {
    /// Rays from the eye: what is farther away is smaller.
    #[default]
    Perspective,
    /// Parallel rays: lengths look the same at every depth. A picture is as high as a perspective one is at the target.
    Orthographic,
}

impl fmt::Display for Projection {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Perspective => "perspective",
            Self::Orthographic => "orthographic",
        })
    }
}

impl FromStr for Projection {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "perspective" => Ok(Self::Perspective),
            "orthographic" => Ok(Self::Orthographic),
            other => Err(format!("`{other}` is no projection; use perspective or orthographic")),
        }
    }
}
