//! MetaImage out: in one file (`.mha`) or with the voxels in a `.raw` beside it (`.mhd`), uncompressed.

use crate::volume::detached::{self, Beside};
use crate::volume::voxels::Voxels;
use crate::volume::write::one_line;
use crate::{Error, Result, atomic};
use fovol_core::{Dtype, Space, Volume};
use glam::DVec3;
use std::io::Write;
use std::path::Path;

/// Writes `volume` to `path`; its extension decides whether the voxels go to a separate file.
///
/// # Errors
/// Half-precision voxels, which MetaImage lacks; another output's file in the way; errors of the operating system.
pub fn write(volume: &Volume, path: &Path, beside: Beside) -> Result<()> {
    let voxels = Voxels::of(volume);
    let name = type_name(voxels.dtype())
        .ok_or_else(|| Error::unsupported(path, "MetaImage has no half precision; write .raw instead"))?;
    let [nx, ny, nz] = volume.grid().dims();
    let [sx, sy, sz] = volume.grid().spacing();
    let header = format!(
        "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n\
         CompressedData = False\n{place}ElementSpacing = {sx} {sy} {sz}\nDimSize = {nx} {ny} {nz}\n\
         ElementType = {name}\n",
        place = place(volume)
    );
    if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("mhd")) {
        return detached::write(&voxels, path, beside, |file| format!("{header}ElementDataFile = {file}\n"));
    }
    atomic::write(path, |out| {
        writeln!(out, "{header}ElementDataFile = LOCAL")?;
        voxels.write_to(out)
    })
}

/// The fields that place the grid. A matrix stands for the patient's space, so other spaces have none.
fn place(volume: &Volume) -> String {
    let numbers = |vector: DVec3| vector.to_array().map(|number| number.to_string()).join(" ");
    let mut text = String::new();
    if let Some(placement) = volume.placement() {
        if placement.space() == Space::Patient {
            let axes = placement.directions();
            let rows = [axes.x_axis, axes.y_axis, axes.z_axis].map(numbers).join(" ");
            text += &format!("TransformMatrix = {rows}\n");
        }
        text += &format!("Offset = {}\nCenterOfRotation = 0 0 0\n", numbers(placement.origin()));
    }
    if let Some(units) = volume.units() {
        text += &format!("DistanceUnits = {}\n", one_line(units));
    }
    text
}

fn type_name(dtype: Dtype) -> Option<&'static str> {
    Some(match dtype {
        Dtype::U8 => "MET_UCHAR",
        Dtype::I8 => "MET_CHAR",
        Dtype::U16 => "MET_USHORT",
        Dtype::I16 => "MET_SHORT",
        Dtype::U32 => "MET_UINT",
        Dtype::I32 => "MET_INT",
        Dtype::U64 => "MET_ULONG_LONG",
        Dtype::I64 => "MET_LONG_LONG",
        Dtype::F16 => return None,
        Dtype::F32 => "MET_FLOAT",
        Dtype::F64 => "MET_DOUBLE",
    })
}
