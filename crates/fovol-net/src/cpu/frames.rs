//! Frames as the maps that networks read and write.

use super::map::{Map, Stored};
use fovol_core::{Frame, FrameSize};
use rayon::prelude::*;

/// What a network is given for one frame.
#[derive(Debug, Clone, Copy)]
pub struct FrameInput<'a> {
    /// The sparse frame: alpha 1 where sampled.
    pub sparse: &'a Frame,
    /// For each pixel the way (x right, y down, in pixels) to where it was in the last frame; networks that do
    /// not use motion ignore it, for others none means stillness.
    pub motion: Option<&'a [[f32; 2]]>,
}

/// An image whose pixels `fill` writes, given their place in a frame of `size`; replicated at the right and bottom.
pub fn padded_map(
    mut map: Map,
    size: FrameSize,
    [height, width, channels]: [usize; 3],
    fill: impl Fn(usize, &mut [f32]) + Sync,
) -> Stored {
    map.resize([height, width, channels]);
    map.data.par_chunks_exact_mut(width * channels).enumerate().for_each(|(y, row)| {
        let y = y.min(size.height as usize - 1);
        for (x, to) in row.chunks_exact_mut(channels).enumerate() {
            fill(y * size.width as usize + x.min(size.width as usize - 1), to);
        }
    });
    Stored::F32(map)
}

/// `pixels` of a frame of `size`, two numbers each, as an image; replicated at the right and bottom. Zeros if there are none.
pub fn padded_pairs(
    pixels: Option<&[[f32; 2]]>,
    mut map: Map,
    size: FrameSize,
    [height, width]: [usize; 2],
) -> Stored {
    map.resize([height, width, 2]);
    let [lines, columns] = [size.height as usize, size.width as usize];
    map.data.par_chunks_exact_mut(2 * width).enumerate().for_each(|(y, row)| {
        let Some(pixels) = pixels else { return row.fill(0.0) };
        let from = &pixels[y.min(lines - 1) * columns..][..columns];
        let (inside, beyond) = row.as_chunks_mut().0.split_at_mut(columns);
        inside.copy_from_slice(from);
        beyond.fill(from[columns - 1]);
    });
    Stored::F32(map)
}

/// Makes `frame` the picture in the top left of `map`, clamped to 0…1.
pub fn crop(map: &Map, frame: &mut Frame) {
    let width = frame.size().width as usize;
    frame.pixels_mut().par_chunks_exact_mut(width).enumerate().for_each(|(y, row)| show(map.row(y), row));
}

/// Makes `to` the first pixels of a `row` of a picture, clamped to 0…1.
pub fn show(row: &[f32], to: &mut [[f32; 4]]) {
    for (to, &[r, g, b]) in to.iter_mut().zip(row.as_chunks().0) {
        *to = [r.clamp(0.0, 1.0), g.clamp(0.0, 1.0), b.clamp(0.0, 1.0), 1.0];
    }
}
