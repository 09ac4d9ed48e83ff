use super::descriptor::{Descriptor, one_output};
use super::samples::{check_half, check_known};
use super::spread::MOST_HALVINGS;
use crate::plan::tensor::{TensorId, TensorSpec};

/// Term that [`HistoryConfidence`] adds to the variance of the samples: the square of a quarter of an 8-bit step.
pub const CONFIDENCE_EPSILON: f32 = 1e-6;
/// Part of the samples' variance up to which an error of the history is no reason for less confidence: ¼ in
/// docs/guide/src/internals/algorithm.md, section 5.
pub const CONFIDENCE_ALLOWED: f32 = 0.25;
/// Factor of the error beyond the allowed part: ½ in docs/guide/src/internals/algorithm.md, section 5. It is less
/// than 1 because the fill in this comparison is smoother than the final one.
pub const CONFIDENCE_SHARE: f32 = 0.5;

/// Level of the confidence map: one value for a square of 2³ × 2³ pixels.
const LEVEL: u32 = 3;

/// Confidence in the history, 0…1: v / (v + [`CONFIDENCE_SHARE`] · max(e − [`CONFIDENCE_ALLOWED`] · v, 0)).
///
/// e and v are mean squared differences between this frame's samples and `prior` or `fresh`, spread over the
/// frame; [`CONFIDENCE_EPSILON`] is added to v. The confidence is 1 where `prior` predicts the samples much better
/// than their neighbours do, so that still pictures keep all earlier samples. Elsewhere history and samples
/// weigh about as the inverses of their variances. See docs/guide/src/internals/algorithm.md, section 5.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct HistoryConfidence {
    /// [Weighted](crate::plan::Join) pixels of this frame.
    pub known: TensorId,
    /// Last output, reprojected.
    pub prior: TensorId,
    /// Fill of this frame's samples at half the resolution, so smooth that a sample has little influence on its
    /// own value.
    pub fresh: TensorId,
    /// Number of times that the resolution is halved.
    pub levels: u32,
    /// Output tensor, of one channel; its level is the lowest of the levels that are computed.
    pub output: TensorId,
}

impl HistoryConfidence {
    /// Rates how far the reprojected picture `prior` can be trusted, given the samples `known` and their fill `fresh`.
    pub fn new(known: TensorId, prior: TensorId, fresh: TensorId) -> Self {
        Self { known, prior, fresh, levels: 0, output: TensorId::UNSET }
    }
}

impl Descriptor for HistoryConfidence {
    fn name(&self) -> &str {
        "doubt"
    }

    fn inputs(&self) -> Vec<TensorId> {
        vec![self.known, self.prior, self.fresh]
    }

    one_output!();

    fn check(&self, tensors: &[TensorSpec]) -> Result<TensorSpec, String> {
        check_known(&tensors[self.known.index()])?;
        check_half(&tensors[self.fresh.index()])?;
        Ok(TensorSpec { name: "believed".into(), channels: 1, level: 0 })
    }

    fn complete(&mut self, halvings: u32, tensors: &mut [TensorSpec]) {
        self.levels = halvings.min(MOST_HALVINGS);
        tensors[self.output.index()].level = halvings.min(LEVEL);
    }
}
