//! Networks as lists of fused layers: what every engine, the exporter and the trainer walk.

mod build;
mod deepfovea;
mod layer;
mod wnet;

pub use build::PlanBuilder;
pub use deepfovea::DeepFoveaConfig;
pub use layer::{
    Activation, Conv, DOUBT_ALLOWED, DOUBT_EPSILON, DOUBT_SHARE, Filter, Layer, Norm, Normalisation, POINT,
    Padding, Read, Resize, SQUARED_EPSILON, Taps,
};
pub use wnet::{Feedback, WNetConfig};

use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// A tensor of a [`Plan`], by its place in [`Plan::tensors`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct TensorId(pub(crate) usize);

impl TensorId {
    /// Its place in [`Plan::tensors`].
    pub fn index(self) -> usize {
        self.0
    }
}

/// The shape of a tensor: `channels` numbers for each square of 2^`level` × 2^`level` pixels.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Tensor {
    /// What it is called in exports.
    pub name: String,
    /// Numbers per square.
    pub channels: usize,
    /// log₂ of the edge of a square in pixels.
    pub level: u32,
}

/// What a network carries from one frame to the next; zeros start a clip.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StateTensor {
    /// What it is called in exports, after `state.` and `next.`.
    pub name: String,
    /// As it comes from the last frame.
    pub previous: TensorId,
    /// As it goes to the next one.
    pub next: TensorId,
}

/// What a network is given with each frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Inputs {
    /// Red, green, blue in 0…1; 0 where unsampled.
    pub colour: TensorId,
    /// 1 where sampled, 0 elsewhere; for networks that want to know.
    pub mask: Option<TensorId>,
    /// Pixels from here to where this was in the last frame, x right, y down; for networks that use motion.
    pub motion: Option<TensorId>,
}

/// A learned array of a network.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Parameter {
    /// Its name, as in the weights file.
    pub name: String,
    /// Its shape; convolutions are \[out, in, rows, columns\].
    pub shape: Vec<usize>,
}

impl Parameter {
    /// How many numbers it has.
    pub fn len(&self) -> usize {
        self.shape.iter().product()
    }

    /// Whether it has none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// A network: layers in the order of their execution, every tensor written once.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    pub(crate) tensors: Vec<Tensor>,
    pub(crate) layers: Vec<Layer>,
    pub(crate) states: Vec<StateTensor>,
    pub(crate) inputs: Inputs,
    pub(crate) output: TensorId,
}

impl Plan {
    /// All tensors; a [`TensorId`] is a place in this list.
    pub fn tensors(&self) -> &[Tensor] {
        &self.tensors
    }

    /// One tensor.
    pub fn tensor(&self, id: TensorId) -> &Tensor {
        &self.tensors[id.0]
    }

    /// The layers, each after those it reads from.
    pub fn layers(&self) -> &[Layer] {
        &self.layers
    }

    /// What goes from frame to frame.
    pub fn states(&self) -> &[StateTensor] {
        &self.states
    }

    /// What comes in with each frame.
    pub fn inputs(&self) -> Inputs {
        self.inputs
    }

    /// The picture: three channels of level 0, to be clamped to 0…1.
    pub fn output(&self) -> TensorId {
        self.output
    }

    /// Widths and heights must be multiples of this; frames are padded by replication and cropped again.
    pub fn multiple(&self) -> usize {
        1 << self.tensors.iter().map(|tensor| tensor.level).max().unwrap_or(0)
    }

    /// The learned arrays, in the order of the layers.
    pub fn parameters(&self) -> Vec<Parameter> {
        self.layers.iter().flat_map(|layer| layer.parameters(&self.tensors)).collect()
    }

    /// Multiplications and additions for a pixel, counted as pairs.
    pub fn macs_per_pixel(&self) -> f64 {
        self.layers.iter().map(|layer| layer.macs_per_pixel(&self.tensors)).sum()
    }
}

/// Which network: what a [`Plan`] is made from, and what a weights file says about itself.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum NetworkConfig {
    /// U-Nets with recurrent decoders, with or without predicted kernels.
    #[serde(rename = "wnet")]
    WNet(WNetConfig),
    /// The generator of DeepFovea as it was published.
    #[serde(rename = "deepfovea")]
    DeepFovea(DeepFoveaConfig),
}

impl NetworkConfig {
    /// The network's plan.
    ///
    /// # Errors
    /// Widths that do not fit together, in one line.
    pub fn plan(&self) -> Result<Plan, String> {
        match self {
            Self::WNet(config) => config.plan(),
            Self::DeepFovea(config) => config.plan(),
        }
    }
}

/// Networks that have names.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Named {
    /// FoVolNet with the widths of the paper.
    WNetPaper,
    /// The same with 32 channels in the last decoder, as in the authors' release.
    WNetNarrow,
    /// Ours: half the resolution inside, samples accumulated along the motion, filled, and kept.
    WNetFast,
    /// What the FoVolNet paper compared itself with.
    DeepFoveaFvn,
    /// DeepFovea's generator as published.
    DeepFoveaOrig,
}

impl Named {
    /// All of them.
    pub const ALL: [Self; 5] =
        [Self::WNetPaper, Self::WNetNarrow, Self::WNetFast, Self::DeepFoveaFvn, Self::DeepFoveaOrig];

    /// As it is written.
    pub fn name(self) -> &'static str {
        match self {
            Self::WNetPaper => "wnet-paper",
            Self::WNetNarrow => "wnet-narrow",
            Self::WNetFast => "wnet-fast",
            Self::DeepFoveaFvn => "deepfovea-fvn",
            Self::DeepFoveaOrig => "deepfovea-orig",
        }
    }

    /// Its configuration.
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

#[cfg(test)]
mod tests;
