use crate::plan::tensor::{TensorId, TensorSpec};

/// Change of resolution while a tensor is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Resize {
    /// Unchanged.
    Same,
    /// Doubled along each axis: bilinear between pixel centres (`align_corners=false`), replicated at the border.
    Bilinear,
    /// Doubled along each axis: nearest neighbour.
    Nearest,
}

/// A tensor as an input of a layer, with its change of resolution.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Read {
    /// The tensor.
    pub tensor: TensorId,
    /// Its change of resolution.
    pub resize: Resize,
}

impl Read {
    /// Reads `tensor` at its own resolution.
    pub fn same(tensor: TensorId) -> Self {
        Self { tensor, resize: Resize::Same }
    }

    /// Reads `tensor` at twice its resolution, bilinearly.
    pub fn bilinear(tensor: TensorId) -> Self {
        Self { tensor, resize: Resize::Bilinear }
    }

    /// Reads `tensor` at twice its resolution, by nearest neighbour.
    pub fn nearest(tensor: TensorId) -> Self {
        Self { tensor, resize: Resize::Nearest }
    }

    /// Level at which the tensor is delivered, one of `tensors`.
    ///
    /// # Errors
    /// A tensor of full resolution that is to be doubled.
    pub(super) fn level(self, tensors: &[TensorSpec]) -> Result<u32, String> {
        let tensor = &tensors[self.tensor.index()];
        match self.resize {
            Resize::Same => Ok(tensor.level),
            Resize::Bilinear | Resize::Nearest => {
                tensor.level.checked_sub(1).ok_or_else(|| format!("`{}` has full resolution", tensor.name))
            }
        }
    }
}

/// Level at which all of `reads` are delivered.
///
/// # Errors
/// Reads of different levels, or none at all.
pub(super) fn common_level(
    reads: impl IntoIterator<Item = Read>,
    tensors: &[TensorSpec],
) -> Result<u32, String> {
    let mut levels = reads.into_iter().map(|read| read.level(tensors));
    let first = levels.next().ok_or("there are no inputs")??;
    for level in levels {
        if level? != first {
            return Err("inputs differ in resolution".into());
        }
    }
    Ok(first)
}
