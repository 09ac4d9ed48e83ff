//! Voxels written beside the header that speaks of them.

use super::voxels::Voxels;
use crate::{Error, Result, atomic};
use std::path::Path;

/// Writes `voxels` to `x.raw` beside the header `x.nhdr` or `x.mhd`, and returns that name.
///
/// # Errors
/// A name that text headers cannot hold; what the system said.
pub fn write(voxels: &Voxels<'_>, header: &Path) -> Result<String> {
    let path = header.with_extension("raw");
    let name = path.file_name().and_then(|name| name.to_str());
    // Headers are lines, and `%` makes patterns of them.
    let name =
        name.filter(|name| !name.contains(['\n', '\r', '%']) && name.trim() == *name).ok_or_else(|| {
            Error::unsupported(header, "such a name cannot stand in a header; use letters, digits, - and _")
        })?;
    atomic::write(&path, |out| voxels.write_to(out))?;
    Ok(name.to_owned())
}
