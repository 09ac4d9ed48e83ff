use super::descriptor::{Descriptor, one_output};
use super::samples::check_known;
use crate::plan::tensor::{TensorId, TensorSpec};

/// Adds earlier samples to those of this frame where these leave a gap: k + (1 − w) · fade · share · before. If
/// earlier samples are [points](crate::plan::POINT), new samples become points at the centres of their pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Accumulate {
    /// [Weighted](crate::plan::Join) pixels of this frame.
    pub known: TensorId,
    /// Weighted pixels of earlier frames, or points.
    pub before: TensorId,
    /// Confidence in earlier samples at some lower resolution, read bilinearly; 1 without it.
    pub share: Option<TensorId>,
    /// Factor of the weights of earlier samples.
    pub fade: f32,
    /// Output tensor.
    pub output: TensorId,
}

impl Accumulate {
    /// Keeps `known` and fills its gaps from `before`, with the weights of `before` multiplied by `fade` and `share`.
    pub fn new(known: TensorId, before: TensorId, share: Option<TensorId>, fade: f32) -> Self {
        Self { known, before, share, fade, output: TensorId::UNSET }
    }
}

impl Descriptor for Accumulate {
    fn name(&self) -> &str {
        "accumulate"
    }

    fn inputs(&self) -> Vec<TensorId> {
        [Some(self.known), Some(self.before), self.share].into_iter().flatten().collect()
    }

    one_output!();

    fn check(&self, tensors: &[TensorSpec]) -> Result<TensorSpec, String> {
        let [known, before] = [self.known, self.before].map(|id| &tensors[id.index()]);
        check_known(known)?;
        check_known(before)?;
        Ok(known.derived("accumulated", before.channels, 0))
    }

    fn begins_as(&self) -> Option<TensorId> {
        Some(self.before)
    }
}
