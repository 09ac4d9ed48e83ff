use super::descriptor::{Descriptor, one_input_and_output};
use crate::plan::tensor::{TensorId, TensorSpec};

/// Computes factor · x + offset.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scale {
    /// Input tensor.
    pub input: TensorId,
    /// Output tensor.
    pub output: TensorId,
    /// Factor of each value.
    pub factor: f32,
    /// Number that is added to each product.
    pub offset: f32,
}

impl Scale {
    /// Computes `factor` · `input` + `offset`.
    pub fn new(input: TensorId, factor: f32, offset: f32) -> Self {
        Self { input, factor, offset, output: TensorId::UNSET }
    }
}

impl Descriptor for Scale {
    fn name(&self) -> &str {
        "scale"
    }

    one_input_and_output!();

    fn check(&self, tensors: &[TensorSpec]) -> Result<TensorSpec, String> {
        Ok(tensors[self.input.index()].alike("scaled"))
    }

    fn changed(&self) -> Option<TensorId> {
        Some(self.input)
    }
}
