use super::descriptor::{Descriptor, one_input_and_output};
use super::samples::check_points;
use crate::plan::tensor::{TensorId, TensorSpec};

/// Resamples [points](crate::plan::POINT) at pixel centres. Each point contributes to the four centres around it with
/// bilinear weights. Sums are divided by the total weight where it exceeds 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Splat {
    /// Points.
    pub input: TensorId,
    /// [Weighted](crate::plan::Join) pixels.
    pub output: TensorId,
}

impl Splat {
    /// Resamples the points of `input`.
    pub fn new(input: TensorId) -> Self {
        Self { input, output: TensorId::UNSET }
    }
}

impl Descriptor for Splat {
    fn name(&self) -> &str {
        "splat"
    }

    one_input_and_output!();

    fn check(&self, tensors: &[TensorSpec]) -> Result<TensorSpec, String> {
        let input = &tensors[self.input.index()];
        check_points(input)?;
        Ok(input.derived("splatted", 4, 0))
    }
}
