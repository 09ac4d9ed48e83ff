//! Slices of a stack as a volume.

use super::pages::Slice;
use crate::volume::layout::Layout;
use fovol_core::Contents;

/// Name of the format.
pub const FORMAT: &str = "TIFF stack";

/// How `count` slices like `slice` lie, one after another.
pub fn layout(slice: &Slice, count: usize) -> Layout {
    let [x, y] = slice.size;
    Layout { components: slice.components, ..Layout::new([x, y, count], slice.dtype) }
}

/// Adds the number and meaning of the values per pixel of `slice` to `contents`.
pub fn with_components(contents: Contents, slice: &Slice) -> Contents {
    Contents { components: slice.components, are_colours: slice.is_colour, ..contents }
}
