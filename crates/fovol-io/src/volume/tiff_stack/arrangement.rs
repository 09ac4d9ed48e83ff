//! Arrangement of the planes of a TIFF file, as the program that wrote it describes it.

use super::directories::Reader;
use super::hyperstack::{Hyperstack, Resolution};
use super::{imagej, imagej_displays, ome, shaped};
use crate::Result;
use crate::volume::Source;

/// Tags of the first page that describe the whole file.
const WIDTH: usize = 256;
const HEIGHT: usize = 257;
const DESCRIPTION: usize = 270;
const X_RESOLUTION: usize = 282;
const Y_RESOLUTION: usize = 283;
const RESOLUTION_UNIT: usize = 296;

/// Reads the arrangement of the planes from the first page of `source`.
///
/// # Errors
/// Broken OME-XML.
pub fn arrangement(source: &Source) -> Result<Hyperstack> {
    let Some(reader) = Reader::new(source.bytes()) else { return Ok(Hyperstack::plain(0)) };
    let directories = reader.pages();
    let Some(&first) = directories.first() else { return Ok(Hyperstack::plain(0)) };
    let pages = directories.len();
    let text = reader.text(first, DESCRIPTION).unwrap_or_default();
    let pitch =
        |tag| reader.value(first, tag).filter(|&per_unit| per_unit > 0.0).map(|per_unit| 1.0 / per_unit);
    let pitch = [pitch(X_RESOLUTION), pitch(Y_RESOLUTION)];
    let unit = reader.value(first, RESOLUTION_UNIT).unwrap_or(2.0);
    let resolution = Resolution { pitch, unit };
    let said = if text.starts_with("ImageJ=") {
        let stack = imagej::hyperstack(&text, pages, source.bytes().len(), resolution);
        Hyperstack { displays: imagej_displays::displays(&reader, first), ..stack }
    } else if text.contains("<OME") || text.contains(":OME") {
        ome::hyperstack(source, &text, pages)?
    } else {
        let side = |tag| reader.value(first, tag).unwrap_or(0.0) as usize;
        let stack = shaped::hyperstack(&text, pages, [side(WIDTH), side(HEIGHT)], source.bytes().len());
        stack.unwrap_or_else(|| Hyperstack::plain(pages)).with_print_resolution(resolution)
    };
    Ok(said)
}
