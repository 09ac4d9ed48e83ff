//! Writes VTK XML image data with raw appended values.

use crate::volume::detached::Beside;
use crate::volume::voxels::Voxels;
use crate::volume::write::one_line;
use crate::{Error, Result, atomic};
use fovol_core::{Dtype, Volume};
use glam::DVec3;
use quick_xml::escape::escape;
use std::io::Write;
use std::path::Path;

/// Writes `volume` to `path`.
///
/// # Errors
/// Half-precision voxels, which VTK lacks; errors of the operating system.
pub fn write(volume: &Volume, path: &Path, _: Beside) -> Result<()> {
    let voxels = Voxels::of(volume);
    let kind = type_name(voxels.dtype())
        .ok_or_else(|| Error::unsupported(path, "VTK has no half precision; write .raw instead"))?;
    let extent = volume.grid().dims().map(|dim| format!("0 {}", dim - 1)).join(" ");
    let spacing = volume.grid().spacing().map(|spacing| spacing.to_string()).join(" ");
    let (origin, direction) = place(volume);
    let name = escape(one_line(volume.contents().array_name().unwrap_or("values"))).into_owned();
    let length = (volume.grid().voxels() * voxels.dtype().size()) as u64;
    atomic::write(path, |out| {
        write!(
            out,
            r#"<?xml version="1.0"?>
<VTKFile type="ImageData" version="1.0" byte_order="LittleEndian" header_type="UInt64">
  <ImageData WholeExtent="{extent}" Origin="{origin}" Spacing="{spacing}"{direction}>
    <Piece Extent="{extent}">
      <PointData Scalars="{name}">
        <DataArray type="{kind}" Name="{name}" format="appended" offset="0"/>
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

/// The origin, and the attribute of the directions: the rows of the matrix whose columns are the voxel axes.
fn place(volume: &Volume) -> (String, String) {
    let Some(placement) = volume.placement() else { return ("0 0 0".into(), String::new()) };
    let numbers = |vector: DVec3| vector.to_array().map(|number| number.to_string()).join(" ");
    let rows = placement.directions().transpose();
    let rows = [rows.x_axis, rows.y_axis, rows.z_axis].map(numbers).join(" ");
    (numbers(placement.origin()), format!(" Direction=\"{rows}\""))
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
