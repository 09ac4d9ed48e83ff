use super::descriptor::{Descriptor, one_output};
use super::samples::check_points;
use crate::plan::tensor::{TensorId, TensorSpec};

/// Moves [points](crate::plan::POINT) along the motion. A pixel gathers the points within the square of its size around the
/// place of its centre in the last frame. Several points become their mean, with the largest of their weights.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Reproject {
    /// Points of the last frame.
    pub input: TensorId,
    /// Motion: pixels to the previous position.
    pub motion: TensorId,
    /// Output tensor.
    pub output: TensorId,
}

impl Reproject {
    /// Moves the points of `input` along `motion`.
    pub fn new(input: TensorId, motion: TensorId) -> Self {
        Self { input, motion, output: TensorId::UNSET }
    }
}

impl Descriptor for Reproject {
    fn name(&self) -> &str {
        "reproject"
    }

    fn inputs(&self) -> Vec<TensorId> {
        vec![self.input, self.motion]
    }

    one_output!();

    fn check(&self, tensors: &[TensorSpec]) -> Result<TensorSpec, String> {
        let input = &tensors[self.input.index()];
        check_points(input)?;
        Ok(input.alike("reprojected"))
    }
}
