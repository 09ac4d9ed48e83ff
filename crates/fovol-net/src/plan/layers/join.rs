use super::descriptor::{Descriptor, one_output};
use crate::plan::tensor::{TensorId, TensorSpec};

/// Multiplies colours by weights and appends the weights as a fourth channel: weighted pixels, the input of the
/// filling layers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Join {
    /// Colours, three channels.
    pub colour: TensorId,
    /// Weights, 0…1.
    pub weight: TensorId,
    /// Output tensor, four channels.
    pub output: TensorId,
}

impl Join {
    /// Premultiplies `colour` with `weight` and appends `weight`.
    pub fn new(colour: TensorId, weight: TensorId) -> Self {
        Self { colour, weight, output: TensorId::UNSET }
    }
}

impl Descriptor for Join {
    fn name(&self) -> &str {
        "join"
    }

    fn inputs(&self) -> Vec<TensorId> {
        vec![self.colour, self.weight]
    }

    one_output!();

    fn check(&self, tensors: &[TensorSpec]) -> Result<TensorSpec, String> {
        let colour = &tensors[self.colour.index()];
        Ok(colour.derived("joined", 4, colour.level))
    }
}
