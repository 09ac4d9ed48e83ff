use super::descriptor::{Descriptor, one_output};
use super::samples::{check_half, check_known};
use crate::plan::tensor::{TensorId, TensorSpec};

/// Upper limit of the halvings in layers that spread samples.
pub(super) const MOST_HALVINGS: u32 = 5;

/// Spreads weighted pixels over the frame at half the resolution: where samples are few, by means of larger
/// squares. With a `base` it spreads the residuals of `base` at the samples and adds them to `base`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Spread {
    /// [Weighted](crate::plan::Join) pixels.
    pub known: TensorId,
    /// Picture at half the resolution that is to be corrected.
    pub base: Option<TensorId>,
    /// Number of times that the resolution is halved.
    pub levels: u32,
    /// Output tensor, at half the resolution.
    pub output: TensorId,
}

impl Spread {
    /// Spreads `known`, or with `base` its residuals at the samples, over the frame.
    pub fn new(known: TensorId, base: Option<TensorId>) -> Self {
        Self { known, base, levels: 0, output: TensorId::UNSET }
    }
}

impl Descriptor for Spread {
    fn name(&self) -> &str {
        "spread"
    }

    fn inputs(&self) -> Vec<TensorId> {
        [Some(self.known), self.base].into_iter().flatten().collect()
    }

    one_output!();

    fn check(&self, tensors: &[TensorSpec]) -> Result<TensorSpec, String> {
        let known = &tensors[self.known.index()];
        check_known(known)?;
        self.base.map_or(Ok(()), |base| check_half(&tensors[base.index()]))?;
        Ok(known.derived("spread", 3, 1))
    }

    fn complete(&mut self, halvings: u32, _: &mut [TensorSpec]) {
        self.levels = halvings.min(MOST_HALVINGS);
    }
}
