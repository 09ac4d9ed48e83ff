use super::arrays;
use super::document::{Array, Data, Document};
use crate::Result;
use crate::volume::layout::Layout;
use crate::volume::{Source, numbers};
use fovol_core::{Endian, Volume, VoxelBytes};
use std::sync::Arc;

/// The values of `array` in `layout`, but for the byte order, which the file says.
pub fn values(
    source: &Source,
    document: &Document<'_>,
    array: &Array<'_>,
    mut layout: Layout,
) -> Result<Volume> {
    layout.endian = document.coding.endian;
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
    layout.volume(source, bytes, offset)
}
