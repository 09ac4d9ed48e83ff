use super::deepfovea::DeepFoveaConfig;
use super::definition::Plan;
use super::wnet::WNetConfig;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// Configuration of a network. A [`Plan`] is built from it, and a weights file contains it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum NetworkConfig {
    /// U-Net with recurrent decoders, with or without predicted kernels.
    #[serde(rename = "wnet")]
    WNet(WNetConfig),
    /// Generator of DeepFovea, as published.
    #[serde(rename = "deepfovea")]
    DeepFovea(DeepFoveaConfig),
}

impl NetworkConfig {
    /// Builds the plan of the network.
    ///
    /// # Errors
    /// Widths that do not fit together, in one line.
    pub fn plan(&self) -> Result<Plan, String> {
        match self {
            Self::WNet(config) => Ok(config.plan()),
            Self::DeepFovea(config) => config.plan(),
        }
    }
}

/// Networks with a name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Named {
    /// FoVolNet with the widths of the paper.
    WNetPaper,
    /// FoVolNet with 32 channels in the last decoder, as in the authors' release.
    WNetNarrow,
    /// This project's network. It works at half the resolution, and accumulates samples along the motion.
    WNetFast,
    /// The DeepFovea variant that the FoVolNet paper compares with.
    DeepFoveaFvn,
    /// Generator of DeepFovea, as published.
    DeepFoveaOrig,
}

impl Named {
    /// All named networks.
    pub const ALL: [Self; 5] =
        [Self::WNetPaper, Self::WNetNarrow, Self::WNetFast, Self::DeepFoveaFvn, Self::DeepFoveaOrig];

    /// Name in commands and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::WNetPaper => "wnet-paper",
            Self::WNetNarrow => "wnet-narrow",
            Self::WNetFast => "wnet-fast",
            Self::DeepFoveaFvn => "deepfovea-fvn",
            Self::DeepFoveaOrig => "deepfovea-orig",
        }
    }

    /// Configuration of the network.
    pub fn config(self) -> NetworkConfig {
        match self {
            Self::WNetPaper => NetworkConfig::WNet(WNetConfig::paper()),
            Self::WNetNarrow => NetworkConfig::WNet(WNetConfig::narrow()),
            Self::WNetFast => NetworkConfig::WNet(WNetConfig::fast()),
            Self::DeepFoveaFvn => NetworkConfig::WNet(WNetConfig::deepfovea()),
            Self::DeepFoveaOrig => NetworkConfig::DeepFovea(DeepFoveaConfig::default()),
        }
    }
}

impl fmt::Display for Named {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Named {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let names = Self::ALL.map(Self::name);
        Self::ALL.into_iter().find(|named| named.name().eq_ignore_ascii_case(text)).ok_or_else(|| {
            let meant = fovol_core::did_you_mean(text, &names);
            format!("`{text}` is no network; use one of {}{meant}", names.join(", "))
        })
    }
}
