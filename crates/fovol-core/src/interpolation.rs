use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// How values between voxels are found, before the transfer function.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Interpolation {
    /// Trilinear between the centres of voxels.
    #[default]
    Linear,
    /// The nearest voxel, for labels, between which there is nothing.
    Nearest,
}

impl fmt::Display for Interpolation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Linear => "linear",
            Self::Nearest => "nearest",
        })
    }
}

impl FromStr for Interpolation {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "linear" => Ok(Self::Linear),
            "nearest" => Ok(Self::Nearest),
            other => Err(format!("`{other}` is no interpolation; use linear or nearest")),
        }
    }
}
