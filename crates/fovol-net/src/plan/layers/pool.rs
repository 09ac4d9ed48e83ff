use super::descriptor::{Descriptor, one_input_and_output};
use crate::plan::tensor::{TensorId, TensorSpec};

/// Average of 2×2 pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Pool {
    /// Input tensor.
    pub input: TensorId,
    /// Output tensor.
    pub output: TensorId,
}

impl Pool {
    /// Average of `input`.
    pub fn new(input: TensorId) -> Self {
        Self { input, output: TensorId::UNSET }
    }
}

impl Descriptor for Pool {
    fn name(&self) -> &str {
        "pool"
    }

    one_input_and_output!();

    fn check(&self, tensors: &[TensorSpec]) -> Result<TensorSpec, String> {
        let input = &tensors[self.input.index()];
        Ok(input.derived("pooled", input.channels, input.level + 1))
    }
}
