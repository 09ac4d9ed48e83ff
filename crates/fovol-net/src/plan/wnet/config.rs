use super::flat::Flat;
use super::options::{
    Accumulation, Direct, Feedback, Fill, Filtering, Fresh, Kernels, Prediction, WNetOptions,
};
use super::walk::Walk;
use crate::plan::definition::Plan;
use crate::plan::layers::{Normalisation, Taps};
use serde::{Deserialize, Serialize};

/// Configuration of a U-Net that predicts a picture (D), and of kernels that filter it (K).
///
/// It describes FoVolNet and its variants. Without kernels it describes the network that the FoVolNet paper calls
/// DeepFovea. Its options always fit together.
///
/// ```
/// use fovol_net::plan::{Prediction, WNetConfig};
///
/// let narrow = WNetConfig::paper().with(|options| options.decoder[0] = 16)?;
/// assert!(matches!(narrow.options().prediction, Prediction::Kernels(_)));
/// let problem = WNetConfig::fast().with(|options| options.reproject = false).unwrap_err();
/// assert!(problem.contains("`points` are samples that are accumulated and moved"));
/// # Ok::<(), String>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Flat", into = "Flat")]
pub struct WNetConfig(WNetOptions);

impl TryFrom<Flat> for WNetConfig {
    type Error = String;

    fn try_from(flat: Flat) -> Result<Self, String> {
        Self::new(flat.options()?)
    }
}

impl From<WNetConfig> for Flat {
    fn from(config: WNetConfig) -> Self {
        Self::from(&config.0)
    }
}

impl WNetConfig {
    /// Configuration with `options`.
    ///
    /// # Errors
    /// Widths or options that do not fit together, in one line.
    pub fn new(options: WNetOptions) -> Result<Self, String> {
        options.check()?;
        Ok(Self(options))
    }

    /// Options of the network.
    pub fn options(&self) -> &WNetOptions {
        &self.0
    }

    /// This configuration with some options changed.
    ///
    /// # Errors
    /// Those of [`Self::new`].
    pub fn with(&self, change: impl FnOnce(&mut WNetOptions)) -> Result<Self, String> {
        let mut options = self.0.clone();
        change(&mut options);
        Self::new(options)
    }

    /// Configuration with the widths of the paper: docs/guide/src/internals/algorithm.md, section 4.1.
    pub fn paper() -> Self {
        Self(paper())
    }

    /// Configuration of the paper with 32 channels in the last decoder (the authors' release: "small").
    pub fn narrow() -> Self {
        Self(WNetOptions { decoder: vec![32, 64, 80], ..paper() })
    }

    /// Configuration of `wnet-fast`: docs/guide/src/internals/algorithm.md, section 5.
    pub fn fast() -> Self {
        let fresh = Fresh { taps: Taps::Centre, coarse: true, history_confidence: true };
        let accumulation = Accumulation { weight: 0.98, points: true, fresh: Some(fresh) };
        Self(WNetOptions {
            encoder: vec![16, 16, 32, 48],
            decoder: vec![16, 16, 32],
            recurrent: false,
            fold: true,
            mask: true,
            bypass: true,
            reproject: true,
            feedback: Feedback::Output,
            fill: Some(Fill { corrections: 1, accumulation: Some(accumulation) }),
            prediction: Prediction::Kernels(Kernels {
                normalisation: Normalisation::Squared,
                filtering: Filtering::Once { direct: None },
                history: Some(Taps::Centre),
                filled: Some(Taps::Around),
                addition: true,
            }),
        })
    }

    /// Configuration of `temporal_unet` in the authors' release, which the paper calls DeepFovea.
    pub fn deepfovea() -> Self {
        Self(WNetOptions {
            encoder: vec![32, 64, 128, 128, 128],
            decoder: vec![32, 64, 128, 128],
            feedback: Feedback::None,
            prediction: Prediction::Direct(Direct { residual: false }),
            ..paper()
        })
    }

    /// Builds the plan of the network.
    pub fn plan(&self) -> Plan {
        Walk::new(&self.0).run()
    }
}

fn paper() -> WNetOptions {
    WNetOptions {
        encoder: vec![64, 64, 80, 96],
        decoder: vec![64, 64, 80],
        recurrent: true,
        fold: false,
        mask: false,
        bypass: false,
        reproject: false,
        feedback: Feedback::Direct,
        fill: None,
        prediction: Prediction::Kernels(Kernels {
            normalisation: Normalisation::Squared,
            filtering: Filtering::EveryLevel { direct: Some(Direct { residual: false }) },
            history: None,
            filled: None,
            addition: false,
        }),
    }
}
