use fovol_core::did_you_mean;
use fovol_net::plan::{Named, NetworkConfig};
use fovol_net::{Fill, Weights};
use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// Method that fills sparse frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum Reconstruction {
    /// None; frames stay sparse.
    None,
    /// Classical fill without a network.
    Fill(Fill),
    /// FoVolNet's network, which predicts kernels.
    #[default]
    WNet,
    /// DeepFovea's network, with which the paper compares.
    DeepFovea,
}

impl Reconstruction {
    /// Network whose weights are used if none are named.
    pub fn default_network(self) -> Option<Named> {
        match self {
            Self::None | Self::Fill(_) => None,
            Self::WNet => Some(Named::WNetFast),
            Self::DeepFovea => Some(Named::DeepFoveaFvn),
        }
    }

    /// Method of the network that `weights` name, by name or file. Our own network if they cannot be read; loading them
    /// reports the error.
    pub(crate) fn of_weights(weights: &str) -> Self {
        Weights::named_or_read(weights).map_or(Self::WNet, |weights| Self::by(&weights.config))
    }

    /// Method that uses a network of `config`.
    pub(crate) fn by(config: &NetworkConfig) -> Self {
        let has_kernels =
            matches!(config, NetworkConfig::WNet(config) if config.options().kernels().is_some());
        if has_kernels { Self::WNet } else { Self::DeepFovea }
    }
}

impl fmt::Display for Reconstruction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::None => f.write_str("none"),
            Self::Fill(fill) => fill.fmt(f),
            Self::WNet => f.write_str("wnet"),
            Self::DeepFovea => f.write_str("deepfovea"),
        }
    }
}

impl FromStr for Reconstruction {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.to_ascii_lowercase().as_str() {
            "none" => Ok(Self::None),
            "wnet" => Ok(Self::WNet),
            "deepfovea" => Ok(Self::DeepFovea),
            other => other.parse().map(Self::Fill).map_err(|_| no_reconstruction(text)),
        }
    }
}

/// Error message for `text`, which names no method.
fn no_reconstruction(text: &str) -> String {
    if let Ok(network) = text.parse::<Named>() {
        let how = Reconstruction::by(&network.config());
        return format!("`{text}` is a network; write --reconstruct {how} --weights {network}");
    }
    let meant = did_you_mean(text, &["none", "pull-push", "linear", "wnet", "deepfovea"]);
    format!("`{text}` is no reconstruction; use none, pull-push, linear, wnet or deepfovea{meant}")
}

impl TryFrom<String> for Reconstruction {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        text.parse()
    }
}

impl From<Reconstruction> for String {
    fn from(r: Reconstruction) -> Self {
        r.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_networks_and_slips_are_explained() {
        let said = |text: &str| text.parse::<Reconstruction>().unwrap_err();
        assert!(
            said("wnet-fast").ends_with("write --reconstruct wnet --weights wnet-fast"),
            "{}",
            said("wnet-fast")
        );
        assert!(said("deepfovea-fvn").contains("--reconstruct deepfovea --weights deepfovea-fvn"));
        assert!(said("pullpush").ends_with("did you mean pull-push?"), "{}", said("pullpush"));
        assert_eq!("WNet".parse(), Ok(Reconstruction::WNet));
    }
}
