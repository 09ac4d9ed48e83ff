use super::descriptor::{Descriptor, one_input_and_output};
use crate::plan::tensor::{TensorId, TensorSpec};

/// Folds 2×2 pixels into four times as many channels: channel c of pixel (x, y) of the four becomes 4c + 2y +
/// x.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SpaceToDepth {
    /// Input tensor.
    pub input: TensorId,
    /// Output tensor.
    pub output: TensorId,
}

impl SpaceToDepth {
    /// Folds `input`.
    pub fn new(input: TensorId) -> Self {
        Self { input, output: TensorId::UNSET }
    }
}

impl Descriptor for SpaceToDepth {
    fn name(&self) -> &str {
        "space-to-depth"
    }

    one_input_and_output!();

    fn check(&self, tensors: &[TensorSpec]) -> Result<TensorSpec, String> {
        let input = &tensors[self.input.index()];
        Ok(input.derived("folded", 4 * input.channels, input.level + 1))
    }
}
