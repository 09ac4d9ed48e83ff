use super::descriptor::{Descriptor, one_output};
use super::samples::{check_half, check_known};
use crate::plan::tensor::{TensorId, TensorSpec};

/// Fills weighted pixels from `base`, read bilinearly at twice its resolution: c + (1 − w)·b.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Blend {
    /// [Weighted](crate::plan::Join) pixels.
    pub known: TensorId,
    /// Picture at half the resolution.
    pub base: TensorId,
    /// Output tensor.
    pub output: TensorId,
}

impl Blend {
    /// Fills `known` from `base`, a picture of half the resolution.
    pub fn new(known: TensorId, base: TensorId) -> Self {
        Self { known, base, output: TensorId::UNSET }
    }
}

impl Descriptor for Blend {
    fn name(&self) -> &str {
        "blend"
    }

    fn inputs(&self) -> Vec<TensorId> {
        vec![self.known, self.base]
    }

    one_output!();

    fn check(&self, tensors: &[TensorSpec]) -> Result<TensorSpec, String> {
        let known = &tensors[self.known.index()];
        check_known(known)?;
        check_half(&tensors[self.base.index()])?;
        Ok(known.derived("filled", 3, 0))
    }
}
