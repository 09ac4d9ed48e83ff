//! Named tensors of saved states.

use crate::{Error, Result};
use std::collections::BTreeMap;
use tch::Tensor;

/// Tensors of a saved state by name.
pub(super) struct Saved<'a> {
    tensors: BTreeMap<&'a str, &'a Tensor>,
}

impl<'a> Saved<'a> {
    pub fn new(tensors: &'a [(String, Tensor)]) -> Self {
        Self { tensors: tensors.iter().map(|(name, tensor)| (name.as_str(), tensor)).collect() }
    }

    /// Tensor `name`, whose shape must be `shape`.
    pub fn tensor(&self, name: &str, shape: &[i64]) -> Result<&'a Tensor> {
        let missing = || Error::Saved(format!("`{name}` is missing; begin without it, or take another file"));
        let tensor = self.tensors.get(name).copied().ok_or_else(missing)?;
        if tensor.size() != shape {
            let size = tensor.size();
            let problem = format!("`{name}` is {size:?}, not {shape:?}; take the file of this network");
            return Err(Error::Saved(problem));
        }
        Ok(tensor)
    }

    /// The integer `name`.
    pub fn number(&self, name: &str) -> Result<i64> {
        Ok(self.tensor(name, &[1])?.int64_value(&[0]))
    }
}
