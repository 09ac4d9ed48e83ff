use fovol_core::did_you_mean;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// Values along rays that pixels show.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Mode {
    /// All of them, through the transfer function, lit.
    #[default]
    Composite,
    /// The greatest: maximum intensity projection.
    Mip,
    /// The least.
    Minip,
    /// Their mean.
    Average,
    /// The first crossing of one value: a shaded surface.
    Isosurface,
}

impl Mode {
    /// All modes.
    pub const ALL: [Self; 5] = [Self::Composite, Self::Mip, Self::Minip, Self::Average, Self::Isosurface];

    /// Name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Composite => "composite",
            Self::Mip => "mip",
            Self::Minip => "minip",
            Self::Average => "average",
            Self::Isosurface => "isosurface",
        }
    }

    /// Whether light and shadows change the picture.
    pub fn is_lit(self) -> bool {
        matches!(self, Self::Composite | Self::Isosurface)
    }
}

impl fmt::Display for Mode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Mode {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Self::ALL.into_iter().find(|mode| mode.name().eq_ignore_ascii_case(text)).ok_or_else(|| {
            let names = Self::ALL.map(Self::name);
            format!("`{text}` is no mode; use one of {}{}", names.join(", "), did_you_mean(text, &names))
        })
    }
}
