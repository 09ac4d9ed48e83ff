use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// Kinds of noise.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum NoiseKind {
    /// Blue in space and in time.
    #[default]
    Stbn,
    /// Blue in space, every frame by itself.
    Blue,
    /// White.
    Uniform,
}

impl NoiseKind {
    /// All kinds.
    pub const ALL: [Self; 3] = [Self::Stbn, Self::Blue, Self::Uniform];
}

impl fmt::Display for NoiseKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Stbn => "stbn",
            Self::Blue => "blue",
            Self::Uniform => "uniform",
        })
    }
}

impl FromStr for NoiseKind {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Self::ALL
            .into_iter()
            .find(|kind| kind.to_string() == text)
            .ok_or_else(|| format!("`{text}` is no kind of noise; use stbn, blue or uniform"))
    }
}
