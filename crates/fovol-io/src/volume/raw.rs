//! Bare voxels: size and type come from the file name or from the user.

use super::decompress::{Compression, decompress};
use super::{Overrides, Source};
use crate::Result;
use fovol_core::{Dtype, Endian, Grid, Volume, VoxelBytes};
use std::path::Path;
use std::sync::Arc;

/// Reads `source` as bare voxels, gzip-compressed or not.
///
/// # Errors
/// Size or type unknown, or fewer bytes than they need.
pub fn parse(source: &Source, overrides: &Overrides) -> Result<Volume> {
    let named = Named::of(source.path());
    let dims = overrides.dims.or(named.dims).ok_or_else(|| {
        source.malformed("its size is not known; give --dims X,Y,Z and --dtype, or name it like name_256x256x256_uint8.raw")
    })?;
    let dtype = overrides.dtype.or(named.dtype).ok_or_else(|| {
        source.malformed(
            "its voxel type is not known; give --dtype, or name it like name_256x256x256_uint8.raw",
        )
    })?;
    let grid = Grid::new(dims, overrides.spacing.unwrap_or([1.0; 3]))
        .map_err(|e| source.malformed(e.to_string()))?;
    let endian = overrides.endian.unwrap_or(Endian::Little);
    let bytes: VoxelBytes = if source.bytes().starts_with(&[0x1F, 0x8B]) {
        Arc::new(decompress(
            source,
            source.bytes(),
            Compression::Gzip,
            grid.voxels().saturating_mul(dtype.size()),
        )?)
    } else {
        source.shared()
    };
    Volume::with_layout(grid, dtype, endian, 1, bytes, 0)
        .map(|v| v.with_format("raw"))
        .map_err(|e| source.malformed(e.to_string()))
}

/// What a name like `bonsai_256x256x256_uint8.raw` says.
#[derive(Debug, Default, PartialEq)]
struct Named {
    dims: Option<[usize; 3]>,
    dtype: Option<Dtype>,
}

impl Named {
    fn of(path: &Path) -> Self {
        let name = path.file_name().and_then(|n| n.to_str()).unwrap_or_default();
        let mut named = Self::default();
        for word in name.split(['_', '.', '-', ' ']) {
            let dims: Option<Vec<usize>> = word.split('x').map(|d| d.parse().ok()).collect();
            if let Some(Ok(dims)) = dims.map(<[usize; 3]>::try_from) {
                named.dims = Some(dims);
            } else if let Ok(dtype) = word.parse() {
                named.dtype = Some(dtype);
            }
        }
        named
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_say_size_and_type() {
        let named = Named::of(Path::new("/data/lung_ct_115x157x129_int16.raw.gz"));
        assert_eq!(named, Named { dims: Some([115, 157, 129]), dtype: Some(Dtype::I16) });
        assert_eq!(Named::of(Path::new("x.raw")), Named::default());
    }
}
