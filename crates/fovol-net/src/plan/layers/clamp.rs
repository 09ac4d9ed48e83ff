use super::descriptor::{Descriptor, one_input_and_output};
use crate::plan::tensor::{TensorId, TensorSpec};

/// Clamps values to 0…1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Clamp {
    /// Input tensor.
    pub input: TensorId,
    /// Output tensor.
    pub output: TensorId,
}

impl Clamp {
    /// Clamps `input`.
    pub fn new(input: TensorId) -> Self {
        Self { input, output: TensorId::UNSET }
    }
}

impl Descriptor for Clamp {
    fn name(&self) -> &str {
        "clamp"
    }

    one_input_and_output!();

    fn check(&self, tensors: &[TensorSpec]) -> Result<TensorSpec, String> {
        Ok(tensors[self.input.index()].alike("clamped"))
    }

    fn changed(&self) -> Option<TensorId> {
        Some(self.input)
    }
}
