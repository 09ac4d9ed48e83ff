//! Layout of raw volumes, as far as file names, sidecars and users state it.

use super::gzip;
use crate::volume::decompress::{Compression, decompressed_length};
use crate::volume::layout::{Layout, placed};
use crate::volume::payload::{Blocks, Encoding, Files, Payload, Skip};
use crate::volume::{Overrides, Source};
use crate::{Error, Result};
use fovol_core::{Dtype, Endian, Placement, Volume};

/// Size, type and placement of raw voxels, as far as they are known.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Description {
    /// The file that holds the voxels.
    pub file: Option<String>,
    /// Voxels along x, y, z.
    pub dims: Option<[usize; 3]>,
    /// The type of one component.
    pub dtype: Option<Dtype>,
    /// The byte order.
    pub endian: Option<Endian>,
    /// Interleaved values per voxel.
    pub components: Option<usize>,
    /// The distance between voxels along x, y, z.
    pub spacing: Option<[f64; 3]>,
    /// Bytes before the first voxel.
    pub offset: Option<usize>,
    /// Where the grid lies.
    pub placement: Option<Placement>,
    /// The symbol of the unit of the spacing.
    pub units: Option<String>,
    /// Whether the user set the dims.
    pub dims_are_chosen: bool,
}

impl Description {
    /// Takes the size, type, byte order and spacing from the user's overrides.
    pub fn of_user(overrides: &Overrides) -> Self {
        let Overrides { dims, dtype, endian, spacing, .. } = *overrides;
        Self { dims, dtype, endian, spacing, dims_are_chosen: dims.is_some(), ..Self::default() }
    }

    /// Fills unknown properties from `other`.
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        Self {
            file: self.file.or(other.file),
            dims: self.dims.or(other.dims),
            dtype: self.dtype.or(other.dtype),
            endian: self.endian.or(other.endian),
            components: self.components.or(other.components),
            spacing: self.spacing.or(other.spacing),
            offset: self.offset.or(other.offset),
            placement: self.placement.or(other.placement),
            units: self.units.or(other.units),
            dims_are_chosen: if self.dims.is_some() { self.dims_are_chosen } else { other.dims_are_chosen },
        }
    }

    /// The voxels of `source`, gzip-compressed or not. Bare ones are mapped, not copied.
    ///
    /// # Errors
    /// Size or type unknown, or fewer bytes than they need.
    pub fn volume(&self, source: &Source) -> Result<Volume> {
        let unknown = |what| Error::UnknownLayout { path: source.path().to_owned(), what };
        let dims = self.dims.ok_or_else(|| unknown("size"))?;
        let dtype = self.dtype.ok_or_else(|| unknown("voxel type"))?;
        let layout = Layout {
            spacing: self.spacing.unwrap_or([1.0; 3]),
            endian: self.endian.unwrap_or_default(),
            components: self.components.unwrap_or(1),
            ..Layout::new(dims, dtype)
        };
        let offset = self.offset.unwrap_or(0);
        let needed = layout.length(source)?.saturating_add(offset);
        let is_packed = is_packed(source, needed);
        let encoding = if is_packed { Encoding::Compressed(Compression::Gzip) } else { Encoding::Bare };
        let payload =
            Payload { files: Files::Attached(0), encoding, line_skip: 0, byte_skip: Skip::Bytes(offset) };
        let found = if is_packed { gzip::length(source.bytes()) } else { source.bytes().len() };
        let doubt = found.checked_sub(needed).filter(|&excess| excess > 0);
        let doubt = doubt.map(|excess| too_long(source, &layout, excess));
        let volume = payload.volume(source, layout, Blocks::ONE).map_err(|error| {
            match found_bytes(source, is_packed, needed) {
                Some(found) if self.dims_are_chosen => too_short(source, dims, [needed, found]),
                _ => error,
            }
        })?;
        let volume = placed(volume.with_format("raw"), self.placement, self.units.as_deref());
        Ok(match doubt {
            Some(doubt) => volume.with_note(doubt),
            None => volume,
        })
    }
}

/// The warning about `excess` bytes after the last voxel.
fn too_long(source: &Source, layout: &Layout, excess: usize) -> String {
    let Layout { dims: [x, y, z], dtype, components, .. } = layout;
    let of = if *components == 1 { String::new() } else { format!("{components} x ") };
    format!(
        "{} has {excess} bytes more than {x}x{y}x{z} {of}{dtype} needs; are the dims right?",
        source.path().display()
    )
}

/// The error for a file that is too short for the user's `--dims`.
fn too_short(source: &Source, [x, y, z]: [usize; 3], [needed, found]: [usize; 2]) -> Error {
    source.malformed(format!(
        "--dims {x},{y},{z} needs {needed} bytes, the file has {found}; check --dims and --dtype"
    ))
}

/// Number of bytes in the file, unpacked, if it is less than `needed`; otherwise none.
fn found_bytes(source: &Source, is_packed: bool, needed: usize) -> Option<usize> {
    let found = match is_packed {
        true => decompressed_length(source.bytes(), Compression::Gzip, needed)?,
        false => source.bytes().len(),
    };
    (found < needed).then_some(found)
}

/// Whether `source` is a gzip file that unpacks to `needed` bytes.
///
/// Raw voxels may start with the magic number by chance. Without the extension `.gz`, the file must be too short for
/// raw voxels, and its stated length must be `needed`.
fn is_packed(source: &Source, needed: usize) -> bool {
    let bytes = source.bytes();
    let is_named = source.path().extension().is_some_and(|extension| extension.eq_ignore_ascii_case("gz"));
    bytes.starts_with(&[0x1F, 0x8B]) && (is_named || bytes.len() < needed && gzip::length(bytes) == needed)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn the_first_word_counts() {
        let first = Description { dtype: Some(Dtype::U8), ..Description::default() };
        let second = Description { dtype: Some(Dtype::I8), offset: Some(3), ..Description::default() };
        let both = first.or(second);
        assert_eq!((both.dtype, both.offset), (Some(Dtype::U8), Some(3)));
    }

    #[test]
    fn an_offset_and_too_few_bytes() {
        let said = Description {
            dims: Some([2, 1, 1]),
            dtype: Some(Dtype::U8),
            offset: Some(1),
            ..Description::default()
        };
        let source = Source::from_bytes(Path::new("x.raw"), vec![9, 1, 2]);
        assert_eq!(said.volume(&source).unwrap().value([0, 0, 0]), 1.0);
        let source = Source::from_bytes(Path::new("x.raw"), vec![9, 1]);
        assert!(said.volume(&source).unwrap_err().to_string().contains("ends after 2 of 3"));
    }
}
