use super::descriptor::{Descriptor, one_output};
use crate::plan::tensor::{TensorId, TensorSpec};

/// Samples `input` where each pixel was in the last frame: bilinear, zero outside. Motion is averaged and
/// scaled to the resolution of `input`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Warp {
    /// Input tensor.
    pub input: TensorId,
    /// Motion at level 0: pixels to the previous position.
    pub motion: TensorId,
    /// Output tensor.
    pub output: TensorId,
}

impl Warp {
    /// Moves `input` along `motion`.
    pub fn new(input: TensorId, motion: TensorId) -> Self {
        Self { input, motion, output: TensorId::UNSET }
    }
}

impl Descriptor for Warp {
    fn name(&self) -> &str {
        "warp"
    }

    fn inputs(&self) -> Vec<TensorId> {
        vec![self.input, self.motion]
    }

    one_output!();

    fn check(&self, tensors: &[TensorSpec]) -> Result<TensorSpec, String> {
        Ok(tensors[self.input.index()].alike("warped"))
    }
}
