//! Stacks of ImageJ above 4 GiB: one page, and all further planes right behind it, as no TIFF reader expects.

use super::directories::Reader;
use super::hyperstack::{Chosen, Hyperstack};
use super::pages::Pages;
use super::slices::{FORMAT, layout, with_components};
use crate::Result;
use crate::volume::Source;
use crate::volume::layout::Layout;
use fovol_core::{Endian, Volume};
use std::sync::Arc;

const COMPRESSION: usize = 259;
const STRIP_OFFSETS: usize = 273;

/// The slices of `chosen`; memory-mapped if they are contiguous.
///
/// # Errors
/// Compressed planes, and fewer bytes than the planes need.
pub fn volume(source: &Source, stack: &Hyperstack, chosen: &Chosen, pages: &mut Pages<'_>) -> Result<Volume> {
    pages.begin()?;
    let slice = pages.slice()?;
    let place = first_plane(source).ok_or_else(|| {
        source.malformed("it says several slices and has one, which is compressed; save it again as a stack")
    })?;
    let [x, y] = slice.size;
    let length = x * y * slice.components * slice.dtype.size();
    let layout =
        Layout { spacing: stack.spacing(), endian: place.endian, ..layout(&slice, chosen.pages.len()) };
    let needed = stack.pages.len().saturating_mul(length).saturating_add(place.at);
    if needed > source.bytes().len() {
        return Err(source.malformed(format!(
            "its {} planes need {needed} bytes, the file has {}; copy or download it again",
            stack.pages.len(),
            source.bytes().len()
        )));
    }
    let follows = |pair: &[usize]| pair[1] == pair[0] + 1;
    let volume = match chosen.pages.as_slice() {
        all @ [first, ..] if all.windows(2).all(follows) => {
            layout.volume(source, source.shared(), place.at + first * length)?
        }
        scattered => {
            let plane = |&page: &usize| &source.bytes()[place.at + page * length..][..length];
            let planes: Vec<&[u8]> = scattered.iter().map(plane).collect();
            layout.volume(source, Arc::new(planes.concat()), 0)?
        }
    };
    Ok(volume.with_format(FORMAT).with_contents(with_components(chosen.contents.clone(), &slice)))
}

/// Where planes begin, and their byte order.
struct Place {
    at: usize,
    endian: Endian,
}

/// The first plane of `source`, if it is not compressed.
fn first_plane(source: &Source) -> Option<Place> {
    let reader = Reader::new(source.bytes())?;
    let page = *reader.pages().first()?;
    let is_bare = reader.value(page, COMPRESSION).is_none_or(|compression| compression == 1.0);
    let at = reader.value(page, STRIP_OFFSETS)? as usize;
    is_bare.then_some(Place { at, endian: reader.endian() })
}
