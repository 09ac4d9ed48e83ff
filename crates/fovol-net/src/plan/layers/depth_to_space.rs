use super::descriptor::{Descriptor, one_input_and_output};
use crate::plan::tensor::{TensorId, TensorSpec};

/// Inverse of [`SpaceToDepth`](crate::plan::SpaceToDepth).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DepthToSpace {
    /// Input tensor.
    pub input: TensorId,
    /// Output tensor.
    pub output: TensorId,
}

impl DepthToSpace {
    /// Unfolds `input`.
    pub fn new(input: TensorId) -> Self {
        Self { input, output: TensorId::UNSET }
    }
}

impl Descriptor for DepthToSpace {
    fn name(&self) -> &str {
        "depth-to-space"
    }

    one_input_and_output!();

    fn check(&self, tensors: &[TensorSpec]) -> Result<TensorSpec, String> {
        let input = &tensors[self.input.index()];
        let level =
            input.level.checked_sub(1).ok_or_else(|| format!("`{}` has full resolution", input.name))?;
        Ok(input.derived("unfolded", input.channels / 4, level))
    }
}
