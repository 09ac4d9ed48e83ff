use super::activation::Activation;
use super::descriptor::{Descriptor, one_input_and_output, weights_and_bias};
use crate::plan::tensor::{Parameter, TensorId, TensorSpec};

/// Group normalisation with one group, over all channels and pixels of the frame. An affine map of each channel and
/// an activation follow. ε = 1e-5; docs/guide/src/internals/algorithm.md, section 6.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Norm {
    /// Name of the parameters `name.weight` and `name.bias`, both of one number per channel.
    pub name: String,
    /// Input tensor.
    pub input: TensorId,
    /// Output tensor.
    pub output: TensorId,
    /// Activation function.
    pub activation: Activation,
}

impl Norm {
    /// Normalisation of `input`.
    pub fn new(name: impl Into<String>, input: TensorId, activation: Activation) -> Self {
        Self { name: name.into(), input, output: TensorId::UNSET, activation }
    }
}

impl Descriptor for Norm {
    fn name(&self) -> &str {
        &self.name
    }

    one_input_and_output!();

    fn check(&self, tensors: &[TensorSpec]) -> Result<TensorSpec, String> {
        Ok(TensorSpec { name: self.name.clone(), ..tensors[self.input.index()].clone() })
    }

    fn parameters(&self, tensors: &[TensorSpec]) -> Vec<Parameter> {
        weights_and_bias(&self.name, vec![tensors[self.input.index()].channels])
    }
}
