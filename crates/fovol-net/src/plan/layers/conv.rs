use super::activation::Activation;
use super::descriptor::{Descriptor, one_output, per_pixel, weights_and_bias};
use super::read::{Read, common_level};
use crate::plan::tensor::{Parameter, TensorId, TensorSpec};

/// Values beyond the border of a tensor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Padding {
    /// Zeros.
    Zero,
    /// Values of the nearest pixel. For a border of one this equals TensorFlow's symmetric padding.
    Replicate,
}

/// Convolution: activation(convolution(concatenated inputs) + bias).
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Conv {
    /// Name of the parameters `name.weight` \[out, in, size, size\] and `name.bias` \[out\].
    pub name: String,
    /// Input tensors, concatenated along the channels.
    pub inputs: Vec<Read>,
    /// Output tensor.
    pub output: TensorId,
    /// Number of output channels.
    pub channels: usize,
    /// Edge of the window in pixels: 1 or 3.
    pub size: usize,
    /// Step between windows in pixels: 1 or 2.
    pub stride: usize,
    /// Values beyond the border, for windows of size 3.
    pub padding: Padding,
    /// Activation function.
    pub activation: Activation,
}

impl Conv {
    /// Convolution of `inputs` to `channels` channels with a window of `size` (1 or 3), padded with zeros.
    pub fn new(
        name: impl Into<String>,
        inputs: &[Read],
        channels: usize,
        size: usize,
        activation: Activation,
    ) -> Self {
        Self {
            name: name.into(),
            inputs: inputs.to_vec(),
            output: TensorId::UNSET,
            channels,
            size,
            stride: 1,
            padding: Padding::Zero,
            activation,
        }
    }

    /// 3×3 convolution of `inputs` to `channels` channels with replicated border and a `stride` of 1 or 2.
    pub fn replicating(
        name: impl Into<String>,
        inputs: &[Read],
        channels: usize,
        stride: usize,
        activation: Activation,
    ) -> Self {
        Self { stride, padding: Padding::Replicate, ..Self::new(name, inputs, channels, 3, activation) }
    }

    fn weights(&self, tensors: &[TensorSpec]) -> [usize; 4] {
        let inputs = self.inputs.iter().map(|read| tensors[read.tensor.index()].channels).sum();
        [self.channels, inputs, self.size, self.size]
    }
}

impl Descriptor for Conv {
    fn name(&self) -> &str {
        &self.name
    }

    fn inputs(&self) -> Vec<TensorId> {
        self.inputs.iter().map(|read| read.tensor).collect()
    }

    one_output!();

    fn check(&self, tensors: &[TensorSpec]) -> Result<TensorSpec, String> {
        let level = common_level(self.inputs.iter().copied(), tensors)? + u32::from(self.stride == 2);
        Ok(TensorSpec { name: self.name.clone(), channels: self.channels, level })
    }

    fn parameters(&self, tensors: &[TensorSpec]) -> Vec<Parameter> {
        weights_and_bias(&self.name, self.weights(tensors).to_vec())
    }

    fn macs_per_pixel(&self, tensors: &[TensorSpec]) -> f64 {
        per_pixel(&tensors[self.output.index()], self.weights(tensors).into_iter().product())
    }
}
