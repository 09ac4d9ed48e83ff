use super::descriptor::{Descriptor, one_output, per_pixel, weights_and_bias};
use super::read::{Read, common_level};
use crate::plan::tensor::{Parameter, TensorId, TensorSpec};
use serde::{Deserialize, Serialize};

/// Pixels of an image that a predicted kernel weighs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Taps {
    /// The 3×3 pixels around each pixel, row by row, with zeros beyond the border.
    Around,
    /// The pixel itself.
    Centre,
}

impl Taps {
    /// Number of pixels.
    pub fn count(self) -> usize {
        match self {
            Self::Around => 9,
            Self::Centre => 1,
        }
    }
}

/// Normalisation that brings the weights of a predicted kernel to a sum of 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Normalisation {
    /// (w² + ε) / (Σw² + nε) with ε = 1e-6: the authors' squares, made safe for f16.
    Squared,
    /// Softmax: eʷ / Σeʷ.
    Softmax,
}

/// The ε of [`Normalisation::Squared`].
pub const SQUARED_EPSILON: f32 = 1e-6;

/// Predicted kernel: a 1×1 convolution of `features` gives each pixel's weights, which are normalised and applied
/// to images. All channels share one kernel.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Filter {
    /// Name of the parameters `name.weight` \[expand²·taps, in, 1, 1\] and `name.bias`. With `expand` = 2 each
    /// feature serves four pixels, and tap k of pixel (x, y) of the four is channel 4k + 2y + x.
    pub name: String,
    /// Tensor from which kernels are predicted.
    pub features: TensorId,
    /// Edge of the square of pixels that one feature serves: 1 or 2.
    pub expand: usize,
    /// Images to filter and their taps, in the order of the kernel's weights.
    pub images: Vec<(Read, Taps)>,
    /// Output tensor.
    pub output: TensorId,
    /// Normalisation of the weights.
    pub normalisation: Normalisation,
}

impl Filter {
    /// Number of weights of a kernel.
    pub fn taps(&self) -> usize {
        self.images.iter().map(|(_, taps)| taps.count()).sum()
    }

    fn weights(&self, tensors: &[TensorSpec]) -> [usize; 4] {
        let outputs = self.expand * self.expand * self.taps();
        [outputs, tensors[self.features.index()].channels, 1, 1]
    }
}

impl Descriptor for Filter {
    fn name(&self) -> &str {
        &self.name
    }

    fn inputs(&self) -> Vec<TensorId> {
        let images = self.images.iter().map(|(read, _)| read.tensor);
        std::iter::once(self.features).chain(images).collect()
    }

    one_output!();

    fn check(&self, tensors: &[TensorSpec]) -> Result<TensorSpec, String> {
        let level = common_level(self.images.iter().map(|(read, _)| *read), tensors)?;
        if tensors[self.features.index()].level != level + u32::from(self.expand == 2) {
            return Err("features do not fit the images".into());
        }
        let channels = tensors[self.images[0].0.tensor.index()].channels;
        Ok(TensorSpec { name: self.name.clone(), channels, level })
    }

    fn parameters(&self, tensors: &[TensorSpec]) -> Vec<Parameter> {
        weights_and_bias(&self.name, self.weights(tensors).to_vec())
    }

    fn macs_per_pixel(&self, tensors: &[TensorSpec]) -> f64 {
        let output = &tensors[self.output.index()];
        let predicted =
            per_pixel(&tensors[self.features.index()], self.weights(tensors).into_iter().product());
        predicted + per_pixel(output, self.taps() * output.channels)
    }
}
