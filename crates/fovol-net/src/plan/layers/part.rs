use super::descriptor::{Descriptor, one_input_and_output};
use crate::plan::tensor::{TensorId, TensorSpec};

/// Copies channels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Part {
    /// Input tensor.
    pub input: TensorId,
    /// First channel.
    pub first: usize,
    /// Number of channels.
    pub channels: usize,
    /// Output tensor.
    pub output: TensorId,
}

impl Part {
    /// Copies `channels` channels of `input`, from channel `first` on.
    pub fn new(input: TensorId, first: usize, channels: usize) -> Self {
        Self { input, first, channels, output: TensorId::UNSET }
    }
}

impl Descriptor for Part {
    fn name(&self) -> &str {
        "part"
    }

    one_input_and_output!();

    fn check(&self, tensors: &[TensorSpec]) -> Result<TensorSpec, String> {
        let input = &tensors[self.input.index()];
        if self.first + self.channels > input.channels {
            return Err(format!("`{}` has only {} channels", input.name, input.channels));
        }
        Ok(input.derived("part", self.channels, input.level))
    }
}
