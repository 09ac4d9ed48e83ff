//! Zarr, versions 2 and 3, and OME-Zarr in it: <https://zarr-specs.readthedocs.io/>, <https://ngff.openmicroscopy.org/>.
//!
//! A hierarchy of groups and arrays lies in a folder or a zip archive. Only the chunks of the chosen level, channel and
//! time point are read, by all threads at once.

mod axes;
mod bare;
mod chunks;
mod codec;
mod element;
mod entries;
mod hierarchy;
mod image;
mod json;
mod metadata;
mod ome;
mod part;
mod store;
mod target;
mod window;

use super::array_axes::likeliest;
use super::array_path::is_zarr;
use super::cf::auxiliary;
use super::{Overrides, Source};
use crate::Result;
use bare::{Bare, attributes};
use entries::{Content, Entry, entries, entry_at};
use fovol_core::{Contents, Volume};
use hierarchy::Hierarchy;
use image::Image;
use std::path::Path;
use store::{Archive, Folder, Store};

/// Reads the hierarchy in the folder `path`: the image or array that `overrides` choose, else the image, else the
/// largest array.
///
/// # Errors
/// No group or array there, unknown codecs, damaged chunks, too little memory.
pub fn parse_folder(path: &Path, overrides: &Overrides) -> Result<Volume> {
    // The array of a level says nothing of axes and distances: its image does.
    if overrides.array.is_none()
        && let Ok(whole) = std::path::absolute(path)
        && let (Some(parent), Some(name)) = (whole.parent(), whole.file_name().and_then(|name| name.to_str()))
        && is_zarr(parent)
    {
        let source = Source::from_bytes(path, Vec::new());
        let folder = Folder::new(parent.to_owned());
        let hierarchy = Hierarchy { source: &source, store: &folder };
        if let Some((entry @ Entry { content: Content::Image(_), .. }, Some(level))) =
            entry_at(&hierarchy, name)?
        {
            return volume(&hierarchy, &entry, Some(level), overrides, Contents::default());
        }
    }
    let source = Source::from_bytes(path, Vec::new());
    parse(&source, &Folder::new(path.to_owned()), overrides)
}

/// Reads the hierarchy at the address `url`, as [`parse_folder`] does. An address that ends in `.zip` or `.ozx` is one of an
/// archive.
///
/// # Errors
/// Those of [`parse_folder`], a server that cannot be reached, and one that sends no parts of an archive.
#[cfg(feature = "remote")]
pub fn parse_remote(url: &Path, overrides: &Overrides) -> Result<Volume> {
    let source = Source::from_bytes(url, Vec::new());
    if store::RemoteArchive::is_named_by(&url.to_string_lossy()) {
        return match store::RemoteArchive::open(&url.to_string_lossy())? {
            Some(archive) => parse(&source, &archive, overrides),
            None => Err(no_zarr(&source)),
        };
    }
    let remote = store::Remote::open(&url.to_string_lossy()).map_err(|e| crate::Error::io("read", url, e))?;
    parse(&source, &remote, overrides)
}

/// Whether the zip archive `source` holds a hierarchy.
pub fn is_archive(source: &Source) -> bool {
    source.bytes().starts_with(b"PK\x03\x04") && matches!(Archive::open(source), Ok(Some(_)))
}

/// Reads the hierarchy in the zip archive `source`, as [`parse_folder`] does.
///
/// # Errors
/// Those of [`parse_folder`], and a damaged archive.
pub fn parse_archive(source: &Source, overrides: &Overrides) -> Result<Volume> {
    match Archive::open(source)? {
        Some(archive) => parse(source, &archive, overrides),
        None => Err(no_zarr(source)),
    }
}

/// The error for an archive without Zarr.
fn no_zarr(source: &Source) -> crate::Error {
    source.unsupported("the archive holds no Zarr; unpack it and name a file in it")
}

fn parse(source: &Source, store: &dyn Store, overrides: &Overrides) -> Result<Volume> {
    let hierarchy = Hierarchy { source, store };
    let found = entries(&hierarchy)?;
    let names = || found.iter().map(|entry| entry.name().to_owned()).collect::<Vec<_>>();
    let Some(chosen) = &overrides.array else {
        let shown = &found[shown(&hierarchy, &found)?];
        let only = found.len() == 1 && shown.path.is_empty();
        let contents = if only { Contents::default() } else { listed(names(), shown.name()) };
        return volume(&hierarchy, shown, None, overrides, contents);
    };
    let Some((entry, level)) = entry_at(&hierarchy, chosen)? else {
        return Err(Overrides::no_array(source, chosen, &names()));
    };
    let flag = overrides.level.filter(|flag| level.is_some_and(|level| level != *flag));
    if let Some(flag) = flag {
        return Err(
            source.malformed(format!("--array {chosen} is another level than --level {flag}; leave one out"))
        );
    }
    volume(&hierarchy, &entry, level, overrides, listed(names(), chosen))
}

/// Contents that list `names`, of which `shown` is shown.
fn listed(mut names: Vec<String>, shown: &str) -> Contents {
    let is_shown = |name: &String| name.trim_matches('/') == shown.trim_matches('/');
    let array = names.iter().position(is_shown).unwrap_or_else(|| {
        names.push(shown.to_owned());
        names.len() - 1
    });
    Contents { arrays: names, array, ..Contents::default() }
}

/// The entry to show: the first image that is no label map, else the largest array, else a label map.
fn shown(hierarchy: &Hierarchy<'_>, found: &[Entry]) -> Result<usize> {
    let is_image = |entry: &Entry| matches!(entry.content, Content::Image(_));
    if let Some(image) = found.iter().position(|entry| is_image(entry) && !entry.is_label()) {
        return Ok(image);
    }
    let arrays = || {
        found.iter().map(|entry| match &entry.content {
            Content::Array(Ok(array)) => Some(Bare { hierarchy, path: &entry.path, array }),
            _ => None,
        })
    };
    let described: Vec<_> = arrays().flatten().map(|bare| attributes(bare.array)).collect();
    let auxiliary = auxiliary(described.iter());
    let axes: Vec<_> = arrays()
        .map(|bare| bare.filter(|bare| !auxiliary.contains(bare.path.rsplit('/').next().unwrap_or_default())))
        .map(|bare| bare?.rank())
        .collect();
    let likely = likeliest(axes.iter().map(Option::as_ref)).or_else(|| found.iter().position(is_image));
    match (likely, found) {
        (Some(index), _) => Ok(index),
        // An array alone says what is wrong with it.
        (None, [_]) => Ok(0),
        (None, []) => Err(hierarchy
            .source
            .unsupported("it holds no arrays of Zarr; is the name right, and the copy whole?")),
        (None, _) => Err(hierarchy.source.unsupported(
            "none of its arrays is a volume; save one with the axes z, y, x, or name one by --array PATH",
        )),
    }
}

fn volume(
    hierarchy: &Hierarchy<'_>,
    entry: &Entry,
    level: Option<usize>,
    overrides: &Overrides,
    contents: Contents,
) -> Result<Volume> {
    let path = entry.path.as_str();
    match &entry.content {
        Content::Image(attributes) => Image { hierarchy, path, attributes, is_label: entry.is_label() }
            .volume(overrides, level, contents),
        Content::Array(Ok(array)) => Bare { hierarchy, path, array }.volume(overrides, contents),
        Content::Array(Err(problem)) => Err(hierarchy.malformed(path, problem)),
    }
}

#[cfg(test)]
mod tests;
