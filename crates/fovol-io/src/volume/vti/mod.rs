//! VTK XML image data: <https://docs.vtk.org/en/latest/vtk_file_formats/vtkxml_file_format.html>.

mod arrays;
mod base64;
mod document;
mod write;
mod xml;

use super::affine::Affine;
use super::layout::{Layout, placed, spacing_of};
use super::{Overrides, Source, numbers};
use crate::Result;
use document::{Data, Document};
use fovol_core::{Endian, Grid, Placement, Space, Volume, VoxelBytes};
use glam::DVec3;
use std::sync::Arc;
pub use write::write;

/// How far into a file its first element is looked for: comments may come before.
const LOOKED_AT: usize = 1 << 10;

/// Whether `bytes` begin as VTK's XML files do.
pub fn is_vtk_xml(bytes: &[u8]) -> bool {
    first_element(bytes).is_some()
}

/// Whether `bytes` begin as VTK's XML files of image data do.
pub fn is_vti(bytes: &[u8]) -> bool {
    first_element(bytes)
        .is_some_and(|element| element.contains("\"ImageData\"") || element.contains("'ImageData'"))
}

/// The text of the element `VTKFile` at the start of `bytes`.
fn first_element(bytes: &[u8]) -> Option<String> {
    let start = String::from_utf8_lossy(&bytes[..bytes.len().min(LOOKED_AT)]).into_owned();
    if !start.trim_start_matches('\u{feff}').trim_start().starts_with('<') {
        return None;
    }
    let element = &start[start.find("<VTKFile")?..];
    Some(element[..element.find('>')?].to_owned())
}

/// Reads a `.vti` file: the chosen array, else the scalars of its points, else of its cells.
///
/// # Errors
/// Broken XML, damaged data, other data than images, types and compressions that are not read.
pub fn parse(source: &Source, overrides: &Overrides) -> Result<Volume> {
    let document = xml::parse(source)?;
    let shown = document.shown(source, overrides)?;
    let array = shown.array;
    let mut layout = Layout {
        dims: shown.dims,
        spacing: spacing_of(&document.spacing),
        dtype: array.dtype(source)?,
        endian: document.coding.endian,
        components: array.components,
    };
    let needed = layout.length(source)?;
    let (bytes, offset): (VoxelBytes, usize) = match array.data {
        Data::Ascii(text) => {
            layout.endian = Endian::Little;
            let values = layout.values(source)?;
            (Arc::new(numbers::decimal(source, text.as_bytes(), layout.dtype, values)?), 0)
        }
        Data::Inline(text) => (Arc::new(arrays::inline(source, document.coding, text, needed)?), 0),
        Data::Appended(offset) => {
            let appended = document
                .appended
                .ok_or_else(|| source.malformed("its AppendedData is missing; is the file cut short?"))?;
            arrays::appended(source, document.coding, appended, offset, needed)?
        }
    };
    let volume =
        layout.volume(source, bytes, offset)?.with_format("VTK XML image data").with_contents(shown.contents);
    let placement = placement(source, &document, shown.is_of_cells, volume.grid())?;
    Ok(placed(volume, placement, None))
}

/// Where the grid lies: the first voxel is the first point of the extent, or the middle of the first cell.
fn placement(
    source: &Source,
    document: &Document<'_>,
    is_of_cells: bool,
    grid: &Grid,
) -> Result<Option<Placement>> {
    if document.origin.is_none() && document.direction.is_none() {
        return Ok(None);
    }
    let rows = document.direction.unwrap_or([1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
    let steps = [0, 1, 2].map(|axis| DVec3::new(rows[axis], rows[3 + axis], rows[6 + axis]));
    let origin = DVec3::from_array(document.origin.unwrap_or_default());
    let zero = Affine { steps, origin }.placement(source, Space::Other)?;
    let [x, _, y, _, z, _] = document.extent.unwrap_or_default();
    let to_middle = if is_of_cells { 0.5 } else { 0.0 };
    let first = DVec3::new(x as f64, y as f64, z as f64) + to_middle;
    Ok(Some(zero.moved_to(first, grid)))
}

#[cfg(test)]
mod tests;
