//! VTK XML image data out: bare appended values.

use crate::volume::voxels::Voxels;
use crate::{Error, Result, atomic};
use fovol_core::{Dtype, Volume};
use std::io::Write;
use std::path::Path;

/// Writes `volume` to `path`.
///
/// # Errors
/// Half precision, which VTK does not have; what the system said.
pub fn write(volume: &Volume, path: &Path) -> Result<()> {
    let voxels = Voxels::of(volume);
    let kind = type_name(voxels.dtype())
        .ok_or_else(|| Error::unsupported(path, "VTK has no half precision; write .raw instead"))?;
    let extent = volume.grid().dims().map(|dim| format!("0 {}", dim - 1)).join(" ");
    let spacing = volume.grid().spacing().map(|spacing| spacing.to_string()).join(" ");
    let length = (volume.grid().voxels() * voxels.dtype().size()) as u64;
    atomic::write(path, |out| {
        write!(
            out,
            r#"<?xml version="1.0"?>
<VTKFile type="ImageData" version="1.0" byte_order="LittleEndian" header_type="UInt64">
  <ImageData WholeExtent="{extent}" Origin="0 0 0" Spacing="{spacing}">
    <Piece Extent="{extent}">
      <PointData Scalars="values">
        <DataArray type="{kind}" Name="values" format="appended" offset="0"/>
      </PointData>
    </Piece>
  </ImageData>
  <AppendedData encoding="raw">
   _"#
        )?;
        out.write_all(&length.to_le_bytes())?;
        voxels.write_to(out)?;
        write!(out, "\n  </AppendedData>\n</VTKFile>\n")
    })
}

fn type_name(dtype: Dtype) -> Option<&'static str> {
    Some(match dtype {
        Dtype::U8 => "UInt8",
        Dtype::I8 => "Int8",
        Dtype::U16 => "UInt16",
        Dtype::I16 => "Int16",
        Dtype::U32 => "UInt32",
        Dtype::I32 => "Int32",
        Dtype::U64 => "UInt64",
        Dtype::I64 => "Int64",
        Dtype::F16 => return None,
        Dtype::F32 => "Float32",
        Dtype::F64 => "Float64",
    })
}
