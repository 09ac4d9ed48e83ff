//! TIFF: the pages of one file, or the files of a folder, as slices from z = 0 on.

mod directories;
mod natural_order;
mod pages;

use super::layout::Layout;
use super::{Overrides, Source};
use crate::{Error, Result};
use fovol_core::{Endian, Volume};
use pages::{Pages, Slice};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Whether `bytes` begin as TIFF and BigTIFF files do.
pub fn is_tiff(bytes: &[u8]) -> bool {
    matches!(bytes, [b'I', b'I', 42 | 43, 0, ..] | [b'M', b'M', 0, 42 | 43, ..])
}

/// Reads all pages of a TIFF file.
///
/// # Errors
/// Damaged files, pages that differ in size or type, types that are not read.
pub fn parse(source: &Source, _overrides: &Overrides) -> Result<Volume> {
    let mut stack = Stack::default();
    let mut pages = Pages::open(source)?;
    while let Some(slice) = pages.begin()? {
        stack.add(source, slice, &mut pages)?;
    }
    stack.volume(source)
}

/// Reads the TIFF files in the folder `path`, in the natural order of their names; none when there are none.
///
/// # Errors
/// As [`parse`], and files of several pages beside others.
pub fn parse_folder(path: &Path, overrides: &Overrides) -> Result<Option<Volume>> {
    let files = files(path)?;
    match files.as_slice() {
        [] => return Ok(None),
        [file] => return parse(&Source::open(file)?, overrides).map(Some),
        _ => {}
    }
    let mut stack = Stack::default();
    for file in &files {
        let source = Source::open(file)?;
        let mut pages = Pages::open(&source)?;
        if let Some(slice) = pages.begin()? {
            stack.add(&source, slice, &mut pages)?;
        }
        if pages.begin()?.is_some() {
            return Err(source.malformed(
                "it has several pages among files of one slice each; name this file alone, or take it out of the folder",
            ));
        }
    }
    stack.volume(&Source::from_bytes(path, Vec::new())).map(Some)
}

/// The TIFF files in the folder `path`.
fn files(path: &Path) -> Result<Vec<PathBuf>> {
    let failed = |source| Error::io("read", path, source);
    let mut files = Vec::new();
    for entry in std::fs::read_dir(path).map_err(failed)? {
        let file = entry.map_err(failed)?.path();
        let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let lower = name.to_ascii_lowercase();
        // Some systems leave hidden companions beside files.
        if !name.starts_with('.') && (lower.ends_with(".tif") || lower.ends_with(".tiff")) {
            files.push((name, file));
        }
    }
    files.sort_by(|(a, _), (b, _)| natural_order::compare(a, b));
    Ok(files.into_iter().map(|(_, file)| file).collect())
}

/// Slices that were read.
#[derive(Default)]
struct Stack {
    bytes: Vec<u8>,
    first: Option<Slice>,
    count: usize,
}

impl Stack {
    /// Adds the page that `pages` of `source` began.
    fn add(&mut self, source: &Source, slice: Slice, pages: &mut Pages<'_>) -> Result<()> {
        let first = *self.first.get_or_insert(slice);
        if slice != first {
            return Err(source.malformed(format!(
                "its page {} has {slice}, but the first slice has {first}; all slices must be alike",
                pages.number()
            )));
        }
        self.count += 1;
        pages.decode(&mut self.bytes)
    }

    fn volume(self, source: &Source) -> Result<Volume> {
        let first = self.first.ok_or_else(|| source.malformed("it has no pages that are no previews"))?;
        let [x, y] = first.size;
        let layout = Layout {
            // Decoded pixels have the byte order of this machine.
            endian: if cfg!(target_endian = "big") { Endian::Big } else { Endian::Little },
            components: first.components,
            ..Layout::new([x, y, self.count], first.dtype)
        };
        Ok(layout.volume(source, Arc::new(self.bytes), 0)?.with_format("TIFF stack"))
    }
}

#[cfg(test)]
mod tests;
