//! An image whose pieces are in other files.

use super::document::{Document, Extent, Kind, Shown, points};
use super::values::values;
use super::xml;
use crate::volume::Source;
use crate::volume::layout::Layout;
use crate::{Error, Result};
use fovol_core::memory::{self, Estimate, SMALLER_VOLUME};
use fovol_core::{Endian, Volume, stop};
use std::sync::Arc;

/// The array `shown` of all pieces together, in `layout`.
///
/// # Errors
/// Missing or damaged pieces, pieces that do not fit or leave gaps, too little memory.
pub fn volume(source: &Source, document: &Document<'_>, shown: &Shown<'_>, layout: Layout) -> Result<Volume> {
    let length = layout.length(source)?;
    let opened: Vec<Source> = (document.pieces.iter())
        .filter(|(extent, _)| extent.is_none_or(|extent| points(extent).is_some()))
        .map(|(_, name)| match name {
            Some(name) => source.sibling(name),
            None => Err(source.malformed("a piece in it names no file; write the image again")),
        })
        .collect::<Result<_>>()?;
    // Packed values may be short, but not so short.
    let bytes: usize = opened.iter().map(|piece| piece.bytes().len()).sum();
    if length > bytes.saturating_mul(MOST_BYTES_PER_BYTE) {
        return Err(source.malformed(format!(
            "its pieces have {bytes} bytes, too few for the {length} of its extent; copy or download them again"
        )));
    }
    let scarce = |shortage| Error::memory(source.path(), shortage);
    let work = "putting its pieces together";
    Estimate::new(work).with("its voxels", length as u64).check(SMALLER_VOLUME).map_err(scarce)?;
    let whole = document.extent.unwrap_or_default();
    let mut joined = Joined {
        first: [whole[0], whole[2], whole[4]],
        out: memory::zeroed(length, work, SMALLER_VOLUME).map_err(scarce)?,
        is_there: memory::zeroed(layout.voxels().div_ceil(8), work, SMALLER_VOLUME).map_err(scarce)?,
        layout,
    };
    opened.iter().try_for_each(|piece| joined.add(piece, shown))?;
    let count: usize = joined.is_there.iter().map(|byte| byte.count_ones() as usize).sum();
    if count < joined.layout.voxels() {
        return Err(source.malformed(format!(
            "its pieces leave {} of its voxels out; put all of them beside this file",
            joined.layout.voxels() - count
        )));
    }
    joined.layout.volume(source, Arc::new(joined.out), 0)
}

/// Bytes that one packed byte stands for at most.
const MOST_BYTES_PER_BYTE: usize = 1032;

/// The image, as far as it is put together. Its values are little-endian.
struct Joined {
    /// The first point.
    first: [i64; 3],
    layout: Layout,
    out: Vec<u8>,
    /// A bit for each voxel.
    is_there: Vec<u8>,
}

impl Joined {
    fn add(&mut self, piece: &Source, shown: &Shown<'_>) -> Result<()> {
        let document = xml::parse(piece)?;
        if document.kind != Kind::Image {
            return Err(
                piece.unsupported("it is a piece of an image, but holds no image itself; write it as .vti")
            );
        }
        let (points, extent) = document.points_and_extent(piece)?;
        let attributes = if shown.is_of_cells { &document.cells } else { &document.points };
        let array =
            attributes.arrays.iter().find(|array| array.name == shown.array.name).ok_or_else(|| {
                piece.malformed(format!(
                    "its array `{}` is missing; write all pieces again",
                    shown.array.name.escape_debug()
                ))
            })?;
        let dims = if shown.is_of_cells { points.map(|count| (count - 1).max(1)) } else { points };
        let layout = Layout { dims, components: array.components, ..Layout::new(dims, array.dtype(piece)?) };
        if (layout.dtype, layout.components) != (self.layout.dtype, self.layout.components) {
            return Err(piece.malformed(format!(
                "its array `{}` has another type than in other pieces; write all pieces again",
                shown.array.name.escape_debug()
            )));
        }
        let volume = values(piece, &document, array, layout)?;
        self.copy(&volume, extent);
        Ok(())
    }

    /// Copies the values of a piece at `extent`, as far as they lie in the image.
    fn copy(&mut self, piece: &Volume, extent: Extent) {
        let (from, all) = (piece.grid().dims(), self.layout.dims);
        let size = self.layout.dtype.size();
        let voxel = size * self.layout.components;
        // How far the piece begins behind the image's first voxel, along each axis.
        let shift = [0, 1, 2].map(|axis| extent[2 * axis].saturating_sub(self.first[axis]));
        let place = |axis: usize, index: usize| {
            let at = shift[axis].checked_add(i64::try_from(index).ok()?)?;
            usize::try_from(at).ok().filter(|&at| at < all[axis])
        };
        for z in 0..from[2] {
            stop::point();
            for y in 0..from[1] {
                let (Some(to_z), Some(to_y)) = (place(2, z), place(1, y)) else { continue };
                let row = &piece.data()[(z * from[1] + y) * from[0] * voxel..][..from[0] * voxel];
                for (x, values) in row.chunks_exact(voxel).enumerate() {
                    let Some(to_x) = place(0, x) else { continue };
                    let to = (to_z * all[1] + to_y) * all[0] + to_x;
                    let written = &mut self.out[to * voxel..][..voxel];
                    written.copy_from_slice(values);
                    if piece.endian() == Endian::Big {
                        written.chunks_exact_mut(size).for_each(<[u8]>::reverse);
                    }
                    self.is_there[to / 8] |= 1 << (to % 8);
                }
            }
        }
    }
}
