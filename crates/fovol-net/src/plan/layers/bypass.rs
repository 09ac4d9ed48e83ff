use super::descriptor::{Descriptor, one_output};
use crate::plan::tensor::{TensorId, TensorSpec};

/// Computes mask · colour + (1 − mask) · input.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Bypass {
    /// Sampled colours.
    pub colour: TensorId,
    /// Sample mask: 1 where sampled.
    pub mask: TensorId,
    /// Picture for unsampled pixels.
    pub input: TensorId,
    /// Output tensor.
    pub output: TensorId,
}

impl Bypass {
    /// Takes `colour` where `mask` is 1, and `input` elsewhere.
    pub fn new(colour: TensorId, mask: TensorId, input: TensorId) -> Self {
        Self { colour, mask, input, output: TensorId::UNSET }
    }
}

impl Descriptor for Bypass {
    fn name(&self) -> &str {
        "bypass"
    }

    fn inputs(&self) -> Vec<TensorId> {
        vec![self.colour, self.mask, self.input]
    }

    one_output!();

    fn check(&self, tensors: &[TensorSpec]) -> Result<TensorSpec, String> {
        let [colour, input] = [self.colour, self.input].map(|id| &tensors[id.index()]);
        if (colour.channels, colour.level) != (input.channels, input.level) {
            return Err("the pictures differ in shape".into());
        }
        Ok(input.alike("bypassed"))
    }

    fn changed(&self) -> Option<TensorId> {
        Some(self.input)
    }
}
