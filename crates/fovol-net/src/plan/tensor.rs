//! Tensors of a plan: identifiers, shapes, and arrays that are learned.

/// Identifies a tensor of a [`Plan`](super::Plan) by its index in [`Plan::tensors`](super::Plan::tensors).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct TensorId(pub(crate) usize);

impl TensorId {
    /// Output of a layer that is not yet part of a plan; [`PlanBuilder::add`](super::PlanBuilder::add) sets it.
    pub const UNSET: Self = Self(usize::MAX);

    /// Index in [`Plan::tensors`](super::Plan::tensors).
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

impl TensorSpec {
    /// Shape of `channels` channels at `level`, with the name of this tensor and `suffix`.
    pub fn derived(&self, suffix: &str, channels: usize, level: u32) -> Self {
        Self { name: format!("{}.{suffix}", self.name), channels, level }
    }

    /// This shape, with the name of this tensor and `suffix`.
    pub fn alike(&self, suffix: &str) -> Self {
        self.derived(suffix, self.channels, self.level)
    }
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
