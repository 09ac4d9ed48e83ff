//! Trained weights that are part of the program. `assets/weights` of this crate has their model cards.

use super::Weights;
use crate::plan::Named;
use crate::{Error, Result};
use fovol_core::path_of_text;

static WNET_FAST: &[u8] = include_bytes!("../../assets/weights/wnet-fast.safetensors");
static DEEPFOVEA: &[u8] = include_bytes!("../../assets/weights/deepfovea-fvn.safetensors");
static WNET_PAPER: &[u8] = include_bytes!("../../assets/weights/wnet-paper.safetensors");
static WNET_PAPER_RATIO: &[u8] = include_bytes!("../../assets/weights/wnet-paper-ratio.safetensors");

/// Name of the weights of [`Named::WNetPaper`] that fill light ratios.
const RATIO: &str = "wnet-paper-ratio";

impl Weights {
    /// Networks that [`Self::shipped`] has weights of.
    pub const SHIPPED: [Named; 3] = [Named::WNetFast, Named::WNetPaper, Named::DeepFoveaFvn];

    /// Returns the built-in weights of `network`.
    ///
    /// # Errors
    /// A network without built-in weights.
    pub fn shipped(network: Named) -> Result<Self> {
        let file = Self::shipped_file(network.name()).ok_or_else(|| {
            Error::Weights(format!(
                "none come with this program for {network}; give a file, or one of {}",
                Self::SHIPPED.map(Named::name).join(", ")
            ))
        })?;
        Self::parse(file).map_err(Error::Weights)
    }

    /// Returns the file of the built-in weights `name`, so that callers can detect that it has changed. Upper and lower case
    /// count alike.
    pub fn shipped_file(name: &str) -> Option<&'static [u8]> {
        match name.to_ascii_lowercase().as_str() {
            "wnet-fast" => Some(WNET_FAST),
            "wnet-paper" => Some(WNET_PAPER),
            "deepfovea-fvn" => Some(DEEPFOVEA),
            RATIO => Some(WNET_PAPER_RATIO),
            _ => None,
        }
    }

    /// Reads the weights file `name`, or returns the built-in weights of that name if there is no such file. See
    /// [`fovol_core::path_of_text`] for the path.
    ///
    /// # Errors
    /// Errors of [`Self::shipped`] and [`Self::read`]; a name that is neither a network nor a file.
    pub fn named_or_read(name: &str) -> Result<Self> {
        let path = path_of_text(name);
        if path.exists() {
            return Self::read(&path);
        }
        if let Some(file) = Self::shipped_file(name) {
            return Self::parse(file).map_err(Error::Weights);
        }
        match name.parse::<Named>() {
            Ok(network) => Self::shipped(network),
            Err(problem) if !name.contains(['.', '/', '\\']) => {
                Err(Error::Config(format!("{problem} (nor is there such a file)")))
            }
            Err(_) => Self::read(&path),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_of_light_ratios_are_of_the_papers_network() {
        let weights = Weights::named_or_read("WNet-paper-ratio").unwrap();
        assert_eq!(weights.config, Named::WNetPaper.config());
        assert_ne!(weights.facts, Weights::shipped(Named::WNetPaper).unwrap().facts);
    }

    #[test]
    fn what_is_shipped_fits_its_network() {
        for network in Weights::SHIPPED {
            let weights = Weights::named_or_read(network.name()).unwrap();
            weights.check(&network.config().plan().unwrap()).unwrap();
            assert_eq!(weights.config, network.config());
            assert!(weights.facts.contains_key("steps"), "{:?}", weights.facts);
        }
        assert!(Weights::shipped(Named::WNetNarrow).unwrap_err().to_string().contains("wnet-fast"));
        assert!(
            Weights::named_or_read("nothing.safetensors").unwrap_err().to_string().contains("cannot read")
        );
        assert!(
            Weights::named_or_read("wnet-fst").unwrap_err().to_string().contains("did you mean wnet-fast?")
        );
        assert_eq!(Weights::named_or_read("WNet-Fast").unwrap().config, Named::WNetFast.config());
    }
}
