//! Transfer functions of this and other programs.

mod cie;
mod ciede2000;
mod colour_space;
mod curve;
mod groups;
mod imported;
mod indexed;
#[cfg(feature = "files")]
mod inviwo;
mod joined;
mod json;
mod paraview;
mod prolab;
mod table;
#[cfg(test)]
mod tests;
mod volume_property;
mod warp;
#[cfg(feature = "files")]
mod xml;

pub use imported::Imported;

#[cfg(feature = "files")]
use crate::atomic;
use crate::{Error, Result};
use fovol_core::{TransferFunction, input, path_of_text, text_of_path};
use imported::UNKNOWN;
use std::io::Read;
use std::path::Path;

/// Largest file that is read, in bytes; collections of colour maps are smaller.
const LARGEST: u64 = 64 << 20;

/// Reads the transfer function at `path`.
///
/// If a file holds several functions, the first one is read. A `path` ending in `#NAME` selects the one called `NAME`.
/// Formats:
///
/// - FoVolNet's JSON: `{"points":[[v,r,g,b,a],…]}`, with `"range":[lo,hi]` in data values
/// - JSON colour maps of ParaView and vtk.js
/// - volume properties of 3D Slicer and VTK (`presets.xml`, `.vp`) and of vtk.js
/// - Inviwo `.itf`
/// - tables of colours
///
/// XML (`presets.xml`, `.itf`) needs the cargo feature `files`.
///
/// # Errors
/// A file that is missing, damaged, or none of these.
pub fn import(path: &Path) -> Result<Imported> {
    let (path, name) = with_name(path);
    let failed = |e| Error::io("read", &path, e);
    let file = input::open(&path).map_err(failed)?;
    let size = file.metadata().map_err(failed)?.len();
    if size > LARGEST {
        return Err(Error::malformed(
            &path,
            "it is too large for a transfer function; give a JSON, XML, .vp or .itf file",
        ));
    }
    let mut bytes = Vec::new();
    file.take(LARGEST).read_to_end(&mut bytes).map_err(failed)?;
    let text = String::from_utf8(bytes).map_err(|_| Error::malformed(&path, UNKNOWN))?;
    parse(&path, &text, name.as_deref())
}

/// Reads the transfer function at `path` as its file means it, see [`import`].
///
/// # Errors
/// Those of [`import`].
pub fn read(path: &Path) -> Result<TransferFunction> {
    Ok(import(path)?.as_meant())
}

/// Parses `text`, read from `path`. If it holds several functions, `name` selects one.
///
/// # Errors
/// Those of [`import`].
pub fn parse(path: &Path, text: &str, name: Option<&str>) -> Result<Imported> {
    let mut imported = parse_kind(path, text, name)?;
    imported.notes.iter_mut().for_each(|note| *note = crate::error::plain(&note));
    Ok(imported)
}

fn parse_kind(path: &Path, text: &str, name: Option<&str>) -> Result<Imported> {
    let text = text.trim_start_matches('\u{feff}');
    if text.trim_start().starts_with('<') {
        #[cfg(feature = "files")]
        return xml::parse(path, text, name);
        #[cfg(not(feature = "files"))]
        return Err(Error::unsupported(path, "it is XML, which this program does not read; save it as JSON"));
    }
    if text.trim_start().starts_with(['{', '[']) {
        return json::parse(path, text, name);
    }
    if table::is_table(text) {
        return table::parse(path, text);
    }
    if volume_property::is_vp(text)
        && let Some(lists) = volume_property::Lists::of_lines(text)
    {
        return lists.read(path);
    }
    Err(Error::malformed(path, UNKNOWN))
}

/// Writes `transfer` as our JSON.
///
/// # Errors
/// Errors of the operating system.
#[cfg(feature = "files")]
pub fn write(path: &Path, transfer: &TransferFunction) -> Result<()> {
    use std::io::Write;

    let text = serde_json::to_string(transfer).map_err(|e| Error::malformed(path, e.to_string()))?;
    atomic::write(path, |out| writeln!(out, "{text}"))
}

/// Splits `file.json#NAME`, unless a file of that very name exists.
fn with_name(path: &Path) -> (std::path::PathBuf, Option<String>) {
    match text_of_path(path).rsplit_once('#') {
        Some((file, name)) if !path.exists() => (path_of_text(file).into_owned(), Some(name.to_owned())),
        _ => (path.to_owned(), None),
    }
}
