//! TIFF: the pages of one file, or the files of a folder, as slices from z = 0 on.

mod arrangement;
mod directories;
mod hyperstack;
mod imagej;
mod imagej_displays;
mod ome;
mod one_page;
mod pages;
mod shaped;
mod slices;

use super::channel_window::windowed;
use super::layout::{Layout, placed};
use super::{Overrides, Source};
use crate::{Error, Result, natural_order};
use arrangement::arrangement;
use fovol_core::{Contents, Endian, Volume};
use hyperstack::Hyperstack;
use pages::{Pages, Slice};
use slices::{FORMAT, layout, with_components};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Whether `bytes` begin as TIFF and BigTIFF files do.
pub fn is_tiff(bytes: &[u8]) -> bool {
    matches!(bytes, [b'I', b'I', 42 | 43, 0, ..] | [b'M', b'M', 0, 42 | 43, ..])
}

/// Reads a volume from a TIFF file: the channel and time point that `overrides` choose, by default the first.
///
/// # Errors
/// Damaged files, pages that differ in size or type, unsupported types, and a channel or time point out of range.
pub fn parse(source: &Source, overrides: &Overrides) -> Result<Volume> {
    let (source, is_inverted) = &directories::as_stored(source);
    let mut pages = Pages::open(source)?;
    let hyperstack = arrangement(source)?;
    let chosen = hyperstack.chosen(source, overrides)?;
    let volume = match hyperstack.is_one_page {
        true => one_page::volume(source, &hyperstack, &chosen, &mut pages)?,
        false => {
            let mut stack = Stack::default();
            stack.add_pages(source, &chosen.pages, &mut pages)?;
            stack.volume(source, hyperstack.spacing(), chosen.contents)?
        }
    };
    let volume = placed(volume, None, hyperstack.units());
    let volume = windowed(volume);
    let volume = hyperstack.notes.iter().fold(volume, |volume, note| volume.with_note(note.as_str()));
    Ok(match is_inverted {
        true => volume.with_note("says that zero is white; values are shown as they are stored"),
        false => volume,
    })
}

/// Reads the TIFF files in the folder `path`, in the natural order of their names; none when there are none.
///
/// # Errors
/// Those of [`parse`], and files of several pages beside others.
pub fn parse_folder(path: &Path, overrides: &Overrides) -> Result<Option<Volume>> {
    let files = files(path)?;
    match files.as_slice() {
        [] => return Ok(None),
        [file] => return parse(&Source::open(file)?, overrides).map(Some),
        _ => {}
    }
    let mut stack = Stack::default();
    let mut first = None;
    for file in &files {
        let (source, _) = &directories::as_stored(&Source::open(file)?);
        let mut pages = Pages::open(source)?;
        if first.is_none() {
            first = Some(arrangement(source)?);
        }
        if pages.begin()? {
            stack.add(source, &mut pages)?;
        }
        if pages.begin()? {
            return Err(source.malformed(
                "it has several pages among files of one slice each; name this file alone, or take it out of the folder",
            ));
        }
    }
    let said = first.unwrap_or_else(|| Hyperstack::plain(0));
    let folder = Source::from_bytes(path, Vec::new());
    let volume = stack.volume(&folder, said.spacing(), Contents::default())?;
    Ok(Some(placed(volume, None, said.units())))
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
    fn add(&mut self, source: &Source, pages: &mut Pages<'_>) -> Result<()> {
        let slice = pages.slice()?;
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

    /// Adds the pages of the numbers `wanted`, in that order.
    fn add_pages(&mut self, source: &Source, wanted: &[usize], pages: &mut Pages<'_>) -> Result<()> {
        let mut places: Vec<usize> = (0..wanted.len()).collect();
        places.sort_by_key(|&place| wanted[place]);
        if places.windows(2).any(|pair| wanted[pair[0]] == wanted[pair[1]]) {
            return Err(source.malformed("its description gives one page to two slices"));
        }
        let mut next = places.iter().map(|&place| wanted[place]).peekable();
        let mut number = 0;
        while next.peek().is_some() && pages.begin()? {
            if next.next_if_eq(&number).is_some() {
                self.add(source, pages)?;
            }
            number += 1;
        }
        if next.peek().is_some() {
            return Err(source.malformed(format!(
                "its description speaks of more slices than its {number} pages; copy or download it again"
            )));
        }
        if places.windows(2).any(|pair| pair[0] > pair[1]) {
            self.reorder(&places);
        }
        Ok(())
    }

    /// Puts the slice that was added as number i to `places[i]`.
    fn reorder(&mut self, places: &[usize]) {
        let length = self.bytes.len() / places.len().max(1);
        let mut ordered = vec![0; self.bytes.len()];
        for (slice, &place) in self.bytes.chunks_exact(length.max(1)).zip(places) {
            ordered[place * length..][..length].copy_from_slice(slice);
        }
        self.bytes = ordered;
    }

    fn volume(self, source: &Source, spacing: [f64; 3], contents: Contents) -> Result<Volume> {
        let first = self.first.ok_or_else(|| source.malformed("it has no pages that are no previews"))?;
        // Decoded pixels have the byte order of this machine.
        let endian = if cfg!(target_endian = "big") { Endian::Big } else { Endian::Little };
        let layout = Layout { endian, spacing, ..layout(&first, self.count) };
        let contents = with_components(contents, &first);
        let volume = layout.volume(source, Arc::new(self.bytes), 0)?;
        let volume = volume.with_format(FORMAT).with_contents(contents);
        Ok(match first.planes {
            0 | 1 => volume,
            planes => volume.with_note(format!(
                "has {planes} separate planes of components a page, the first is shown; save it with interleaved components for the others"
            )),
        })
    }
}

#[cfg(test)]
mod tests;
