//! Lists of numbers in groups, as JSON colour maps hold them.

use crate::{Error, Result};
use serde_json::Value;
use std::path::Path;

/// The numbers of list `key` in groups of N, at least one.
pub fn groups<const N: usize>(path: &Path, map: &Value, key: &str) -> Result<Vec<[f64; N]>> {
    let numbers = map.get(key).and_then(Value::as_array);
    let numbers: Option<Vec<f64>> = numbers.and_then(|list| list.iter().map(Value::as_f64).collect());
    let (groups, rest) = numbers.as_deref().unwrap_or_default().as_chunks::<N>();
    if groups.is_empty() || !rest.is_empty() { Err(not_groups(path, key, N)) } else { Ok(groups.to_vec()) }
}

/// The error for a list whose length is not a multiple of `size`.
pub fn not_groups(path: &Path, key: &str, size: usize) -> Error {
    Error::malformed(
        path,
        format!("{key} is not a list of numbers in groups of {size}; save the colour map again"),
    )
}
