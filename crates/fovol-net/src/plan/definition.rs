use super::layers::Layer;
use super::tensor::{Parameter, TensorId, TensorSpec};

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
        &self.tensors[id.index()]
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
