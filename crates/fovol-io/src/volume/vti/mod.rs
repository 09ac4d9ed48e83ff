//! VTK XML image data, in one file or in pieces, and rectilinear grids: <https://docs.vtk.org/en/latest/vtk_file_formats/vtkxml_file_format.html>.

mod arrays;
mod base64;
mod document;
mod pieces;
mod values;
mod write;
mod xml;

use super::affine::Affine;
use super::layout::{Layout, placed, spacing_of};
use super::rectilinear::Coordinates;
use super::{Overrides, Source};
use crate::Result;
use document::{Document, Kind};
use fovol_core::{Grid, Placement, Space, Volume};
use glam::DVec3;
use values::values;
pub use write::write;

/// How far into a file its first element is looked for: comments may come before.
const LOOKED_AT: usize = 1 << 10;

/// Whether `bytes` begin as VTK's XML files do.
pub fn is_vtk_xml(bytes: &[u8]) -> bool {
    first_element(bytes).is_some()
}

/// Whether `bytes` begin as VTK's XML files of images and rectilinear grids do.
pub fn is_vti(bytes: &[u8]) -> bool {
    let is_of = |element: &str, kind: &str| {
        ['"', '\''].iter().any(|mark| element.contains(&format!("{mark}{kind}{mark}")))
    };
    first_element(bytes).is_some_and(|element| {
        ["ImageData", "RectilinearGrid", "PImageData"].iter().any(|kind| is_of(&element, kind))
    })
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

/// Reads a `.vti`, `.vtr` or `.pvti` file: the chosen array, else the scalars of its points, else of its cells.
///
/// # Errors
/// Broken XML, damaged data, other data than images, types and compressions that are not read, missing pieces.
pub fn parse(source: &Source, overrides: &Overrides) -> Result<Volume> {
    let document = xml::parse(source)?;
    let shown = document.shown(source, overrides)?;
    let layout = Layout {
        dims: shown.dims,
        spacing: spacing_of(&document.spacing),
        components: shown.array.components,
        ..Layout::new(shown.dims, shown.array.dtype(source)?)
    };
    if document.kind == Kind::Parallel {
        let volume = pieces::volume(source, &document, &shown, layout)?;
        let volume = volume.with_format("VTK XML parallel image data").with_contents(shown.contents);
        let placement = placement(source, &document, shown.is_of_cells, volume.grid())?;
        return Ok(placed(volume, placement, None));
    }
    let volume = values(source, &document, shown.array, layout)?.with_contents(shown.contents);
    if document.kind == Kind::Rectilinear {
        let points = document.extent.and_then(document::points).unwrap_or(shown.dims);
        let coordinates = coordinates(source, &document, points)?;
        let coordinates = Coordinates::new(source, &coordinates, points, shown.is_of_cells)?;
        return coordinates.applied(source, volume.with_format("VTK XML rectilinear grid"));
    }
    let volume = volume.with_format("VTK XML image data");
    let placement = placement(source, &document, shown.is_of_cells, volume.grid())?;
    Ok(placed(volume, placement, None))
}

/// The positions of `points` along each axis.
fn coordinates(source: &Source, document: &Document<'_>, points: [usize; 3]) -> Result<[Vec<f64>; 3]> {
    let mut found: [Vec<f64>; 3] = Default::default();
    for (axis, positions) in found.iter_mut().enumerate() {
        let array = document.coordinates.arrays.get(axis).filter(|array| array.components == 1);
        let array = array.ok_or_else(|| {
            source.malformed("its Coordinates are not three arrays of numbers; write the file again")
        })?;
        let layout = Layout::new([points[axis], 1, 1], array.dtype(source)?);
        let volume = values(source, document, array, layout)?;
        *positions = (0..points[axis]).map(|index| volume.value([index, 0, 0])).collect();
    }
    Ok(found)
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
