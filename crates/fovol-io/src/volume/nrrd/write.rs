//! NRRD out: attached (`.nrrd`) or with the voxels in a `.raw` beside it (`.nhdr`), uncompressed.

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
/// Half-precision voxels, which NRRD lacks; another output's file in the way; errors of the operating system.
pub fn write(volume: &Volume, path: &Path, beside: Beside) -> Result<()> {
    let voxels = Voxels::of(volume);
    let name = type_name(voxels.dtype())
        .ok_or_else(|| Error::unsupported(path, "NRRD has no half precision; write .raw instead"))?;
    let [nx, ny, nz] = volume.grid().dims();
    let header = format!(
        "NRRD0004\ntype: {name}\ndimension: 3\n{place}sizes: {nx} {ny} {nz}\n\
         kinds: domain domain domain\nendian: little\nencoding: raw\n",
        place = place(volume)
    );
    if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("nhdr")) {
        return detached::write(&voxels, path, beside, |file| format!("{header}data file: {file}\n"));
    }
    atomic::write(path, |out| {
        writeln!(out, "{header}")?;
        voxels.write_to(out)
    })
}

/// The fields that place the grid.
fn place(volume: &Volume) -> String {
    let spacing = volume.grid().spacing();
    let vector =
        |vector: DVec3| format!("({})", vector.to_array().map(|number| number.to_string()).join(","));
    let units = volume.units().map(|units| one_line(units).replace(['"', '\\'], ""));
    let units = |field: &str| {
        units
            .as_ref()
            .map_or_else(String::new, |units| format!("{field}: \"{units}\" \"{units}\" \"{units}\"\n"))
    };
    let Some(placement) = volume.placement() else {
        let [x, y, z] = spacing;
        return format!("spacings: {x} {y} {z}\n{}", units("units"));
    };
    let space = match placement.space() {
        Space::Patient => "space: left-posterior-superior",
        Space::Other => "space dimension: 3",
    };
    let axes = placement.directions();
    let steps = [axes.x_axis * spacing[0], axes.y_axis * spacing[1], axes.z_axis * spacing[2]];
    format!(
        "{space}\nspace directions: {}\nspace origin: {}\n{}",
        steps.map(vector).join(" "),
        vector(placement.origin()),
        units("space units")
    )
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
