use super::descriptor::{Descriptor, one_input_and_output};
use crate::plan::tensor::{TensorId, TensorSpec};

/// Smooths by (1, 2, 1)/4 along both axes, replicated at the border.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Smooth {
    /// Input tensor.
    pub input: TensorId,
    /// Output tensor.
    pub output: TensorId,
}

impl Smooth {
    /// Smooths `input`.
    pub fn new(input: TensorId) -> Self {
        Self { input, output: TensorId::UNSET }
    }
}

impl Descriptor for Smooth {
    fn name(&self) -> &str {
        "smooth"
    }

    one_input_and_output!();

    fn check(&self, tensors: &[TensorSpec]) -> Result<TensorSpec, String> {
        Ok(tensors[self.input.index()].alike("smooth"))
    }
}
