//! NRRD out: attached (`.nrrd`) or with the voxels in a `.raw` beside it (`.nhdr`), uncompressed.

use crate::volume::detached;
use crate::volume::voxels::Voxels;
use crate::{Error, Result, atomic};
use fovol_core::{Dtype, Volume};
use std::io::Write;
use std::path::Path;

/// Writes `volume` to `path`; its ending says whether the voxels go into a file of their own.
///
/// # Errors
/// Half precision, which NRRD does not have; what the system said.
pub fn write(volume: &Volume, path: &Path) -> Result<()> {
    let voxels = Voxels::of(volume);
    let name = type_name(voxels.dtype())
        .ok_or_else(|| Error::unsupported(path, "NRRD has no half precision; write .raw instead"))?;
    let [nx, ny, nz] = volume.grid().dims();
    let [sx, sy, sz] = volume.grid().spacing();
    let header = format!(
        "NRRD0004\ntype: {name}\ndimension: 3\nsizes: {nx} {ny} {nz}\nspacings: {sx} {sy} {sz}\n\
         kinds: domain domain domain\nendian: little\nencoding: raw\n"
    );
    if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("nhdr")) {
        let file = detached::write(&voxels, path)?;
        return atomic::write_bytes(path, format!("{header}data file: {file}\n").as_bytes());
    }
    atomic::write(path, |out| {
        writeln!(out, "{header}")?;
        voxels.write_to(out)
    })
}

fn type_name(dtype: Dtype) -> Option<&'static str> {
    Some(match dtype {
        Dtype::U8 => "uint8",
        Dtype::I8 => "int8",
        Dtype::U16 => "uint16",
        Dtype::I16 => "int16",
        Dtype::U32 => "uint32",
        Dtype::I32 => "int32",
        Dtype::U64 => "uint64",
        Dtype::I64 => "int64",
        Dtype::F16 => return None,
        Dtype::F32 => "float",
        Dtype::F64 => "double",
    })
}
