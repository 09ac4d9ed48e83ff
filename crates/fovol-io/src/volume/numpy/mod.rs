//! NumPy arrays: `.npy` files and `.npz` archives.
//!
//! The last axis of an array is x, as in most programs that keep volumes in NumPy: `a[z, y, x]`.

mod fortran;
mod header;
mod npz;

use super::array_axes::ArrayAxes;
use super::layout::Layout;
use super::{Overrides, Source};
use crate::{Error, Result};
use fovol_core::memory::{self, SMALLER_VOLUME};
use fovol_core::{Contents, Volume, VoxelBytes};
use header::Header;
pub use npz::{is_npz, parse as parse_npz};
use std::sync::Arc;

/// The name of the format.
const FORMAT: &str = "NumPy";

/// Whether `bytes` begin as `.npy` files do.
pub fn is_npy(bytes: &[u8]) -> bool {
    bytes.starts_with(header::MAGIC)
}

/// Reads a `.npy` file. Values in C order stay mapped.
///
/// # Errors
/// A damaged header, types that are no single number, shapes that are no volume, too few bytes.
pub fn parse(source: &Source, overrides: &Overrides) -> Result<Volume> {
    let found = header::parse(source.bytes()).map_err(|problem| remark(source, &problem))?;
    Array { source, header: found, bytes: source.shared(), start: 0 }.volume(overrides, Contents::default())
}

/// The error for a remark that follows "it".
fn remark(source: &Source, problem: &str) -> Error {
    source.malformed(format!("it {problem}"))
}

/// An array in C or Fortran order, and the bytes that hold it.
struct Array<'a> {
    source: &'a Source,
    header: Header,
    /// The bytes of a `.npy` file, among others.
    bytes: VoxelBytes,
    /// Where that file begins in `bytes`.
    start: usize,
}

impl Array<'_> {
    /// The volume of the chosen time point. `contents` names the arrays of the archive.
    fn volume(&self, overrides: &Overrides, contents: Contents) -> Result<Volume> {
        let (source, header) = (self.source, &self.header);
        let axes = ArrayAxes::of(&header.shape)
            .map_err(|problem| source.unsupported(format!("its array {problem}")))?;
        let time = overrides.time_of(source, axes.times)?;
        let layout = Layout {
            endian: header.endian,
            components: axes.components,
            ..Layout::new(axes.dims, header.dtype)
        };
        let one = layout.length(source)?;
        let all = one.checked_mul(axes.times).filter(|&all| all <= self.available());
        let all = all.ok_or_else(|| {
            source.malformed(format!(
                "it ends after {} bytes of values, fewer than its shape needs; copy or save it again",
                self.available()
            ))
        })?;
        let (bytes, start) = self.in_c_order(all)?;
        let contents = Contents { arrays: contents.arrays, array: contents.array, ..axes.contents(time) };
        let volume = layout.volume(source, bytes, start + time * one)?;
        let volume = volume.with_format(FORMAT).with_contents(contents);
        let volume = axes.notes.iter().fold(volume, |volume, note| volume.with_note(note.as_str()));
        Ok(match overrides.spacing {
            None => volume.with_note("NumPy files have no spacing, 1 is taken; --spacing X,Y,Z sets another"),
            Some(_) => volume,
        })
    }

    /// Number of bytes after the header.
    fn available(&self) -> usize {
        (*self.bytes).as_ref().len().saturating_sub(self.start + self.header.offset)
    }

    /// The first `length` bytes of values in C order, and where they begin.
    fn in_c_order(&self, length: usize) -> Result<(VoxelBytes, usize)> {
        let start = self.start + self.header.offset;
        if !self.header.is_fortran || self.header.shape.iter().filter(|&&axis| axis > 1).count() < 2 {
            return Ok((Arc::clone(&self.bytes), start));
        }
        let mut ordered = memory::zeroed(length, "putting its axes in order", SMALLER_VOLUME)
            .map_err(|shortage| Error::memory(self.source.path(), shortage))?;
        let values = &(*self.bytes).as_ref()[start..start + length];
        fortran::to_c_order(&self.header.shape, self.header.dtype.size(), values, &mut ordered);
        Ok((Arc::new(ordered), 0))
    }
}

#[cfg(test)]
mod tests;
