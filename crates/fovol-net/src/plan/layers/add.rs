use super::descriptor::{Descriptor, one_output};
use crate::plan::tensor::{TensorId, TensorSpec};

/// Computes input + more.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Add {
    /// First summand.
    pub input: TensorId,
    /// Second summand.
    pub more: TensorId,
    /// Output tensor.
    pub output: TensorId,
}

impl Add {
    /// Sum of `input` and `more`.
    pub fn new(input: TensorId, more: TensorId) -> Self {
        Self { input, more, output: TensorId::UNSET }
    }
}

impl Descriptor for Add {
    fn name(&self) -> &str {
        "add"
    }

    fn inputs(&self) -> Vec<TensorId> {
        vec![self.input, self.more]
    }

    one_output!();

    fn check(&self, tensors: &[TensorSpec]) -> Result<TensorSpec, String> {
        let [input, more] = [self.input, self.more].map(|id| &tensors[id.index()]);
        if (input.channels, input.level) != (more.channels, more.level) {
            return Err("summands differ in shape".into());
        }
        Ok(input.alike("corrected"))
    }

    fn changed(&self) -> Option<TensorId> {
        Some(self.input)
    }
}
