//! Networks as lists of layers. All engines, the ONNX exporter and the trainer work from these plans.

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

/// Identifies a tensor of a [`Plan`] by its index in [`Plan::tensors`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct TensorId(pub(crate) usize);

impl TensorId {
    /// Index in [`Plan::tensors`].
    pub fn index(self) -> usize {
        self.0
    }
}

/// Shape of a tensor: `channels` numbers for each square of 2^`level` × 2^`level` pixels.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TensorSpec {
    /// Name in exports.
    pub name: String,
    /// Numbers per square.
    pub channels: usize,
    /// log₂ of the edge of a square in pixels.
    pub level: u32,
}

/// A tensor that goes from one frame to the next. It is zero in the first frame of a sequence.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StateTensor {
    /// Name in exports, after `state.` and `next.`.
    pub name: String,
    /// Value from the last frame.
    pub previous: TensorId,
    /// Value for the next frame.
    pub next: TensorId,
}

/// Inputs of a network for each frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Inputs {
    /// Red, green and blue in 0…1; 0 where not sampled.
    pub colour: TensorId,
    /// Sample mask: 1 where sampled, else 0. Only for networks that read it.
    pub mask: Option<TensorId>,
    /// Motion: pixels from here to the position in the last frame, x right, y down. Only for networks that read it.
    pub motion: Option<TensorId>,
}

/// A learned array of a network.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Parameter {
    /// Name, as in the weights file.
    pub name: String,
    /// Shape; convolutions are \[out, in, rows, columns\].
    pub shape: Vec<usize>,
}

impl Parameter {
    /// Number of elements.
    pub fn len(&self) -> usize {
        self.shape.iter().product()
    }

    /// Whether there are no elements.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// A network: layers in the order of execution. Every tensor is written once.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    pub(crate) tensors: Vec<TensorSpec>,
    pub(crate) layers: Vec<Layer>,
    pub(crate) states: Vec<StateTensor>,
    pub(crate) inputs: Inputs,
    pub(crate) output: TensorId,
}

impl Plan {
    /// All tensors; a [`TensorId`] is an index into this list.
    pub fn tensors(&self) -> &[TensorSpec] {
        &self.tensors
    }

    /// Returns one tensor.
    pub fn tensor(&self, id: TensorId) -> &TensorSpec {
        &self.tensors[id.0]
    }

    /// Layers, each after those that write its inputs.
    pub fn layers(&self) -> &[Layer] {
        &self.layers
    }

    /// States: tensors that go from frame to frame.
    pub fn states(&self) -> &[StateTensor] {
        &self.states
    }

    /// Inputs for each frame.
    pub fn inputs(&self) -> Inputs {
        self.inputs
    }

    /// Reconstructed picture: three channels of level 0, to be clamped to 0…1.
    pub fn output(&self) -> TensorId {
        self.output
    }

    /// Number that divides the widths and heights of frames that the layers work on. Frames are padded to it by
    /// replication and cropped again.
    pub fn multiple(&self) -> usize {
        1 << self.tensors.iter().map(|tensor| tensor.level).max().unwrap_or(0)
    }

    /// Learned arrays, in the order of the layers.
    pub fn parameters(&self) -> Vec<Parameter> {
        self.layers.iter().flat_map(|layer| layer.parameters(&self.tensors)).collect()
    }

    /// Multiply-adds for one pixel.
    pub fn macs_per_pixel(&self) -> f64 {
        self.layers.iter().map(|layer| layer.macs_per_pixel(&self.tensors)).sum()
    }
}

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
            Self::WNet(config) => config.plan(),
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

#[cfg(test)]
mod tests;
