//! VTK XML image data: <https://docs.vtk.org/en/latest/vtk_file_formats/vtkxml_file_format.html>.

mod arrays;
mod base64;
mod document;
mod write;
mod xml;

use super::layout::{Layout, spacing_of};
use super::{Overrides, Source, numbers};
use crate::Result;
use document::Data;
use fovol_core::{Endian, Volume, VoxelBytes};
use std::sync::Arc;
pub use write::write;

/// Reads a `.vti` file: the chosen array, else the scalars of its points, else of its cells.
///
/// # Errors
/// Broken XML, damaged data, other data than images, types and compressions that are not read.
pub fn parse(source: &Source, overrides: &Overrides) -> Result<Volume> {
    let document = xml::parse(source)?;
    let (array, dims, contents) = document.shown(source, overrides)?;
    let mut layout = Layout {
        dims,
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
    let volume = layout.volume(source, bytes, offset)?.with_format("VTK XML image data").with_contents(contents);
    Ok(match document.orientation.is_empty() {
        true => volume,
        false => volume.with_orientation(document.orientation.join(", ")),
    })
}

#[cfg(test)]
mod tests;
