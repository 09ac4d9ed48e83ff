//! Converts frames to the maps that networks read, and back.

use super::tensor::{AnyTensor, Tensor};
use fovol_core::{Frame, FrameSize};
use rayon::prelude::*;

/// Makes an image of a frame of `size`, replicated at the right and bottom. `fill` writes a pixel, given its index
/// in the frame.
pub fn padded_map(
    mut map: Tensor,
    size: FrameSize,
    [height, width, channels]: [usize; 3],
    fill: impl Fn(usize, &mut [f32]) + Sync,
) -> AnyTensor {
    map.resize([height, width, channels]);
    map.data.par_chunks_exact_mut(width * channels).enumerate().for_each(|(y, row)| {
        let y = y.min(size.height as usize - 1);
        for (x, to) in row.chunks_exact_mut(channels).enumerate() {
            fill(y * size.width as usize + x.min(size.width as usize - 1), to);
        }
    });
    AnyTensor::F32(map)
}

/// Makes an image of two channels of `pixels` of a frame of `size`, replicated at the right and bottom. Without
/// `pixels` it is zero.
pub fn padded_pairs(
    pixels: Option<&[[f32; 2]]>,
    mut map: Tensor,
    size: FrameSize,
    [height, width]: [usize; 2],
) -> AnyTensor {
    map.resize([height, width, 2]);
    let [lines, columns] = [size.height as usize, size.width as usize];
    map.data.par_chunks_exact_mut(2 * width).enumerate().for_each(|(y, row)| {
        let Some(pixels) = pixels else { return row.fill(0.0) };
        let from = &pixels[y.min(lines - 1) * columns..][..columns];
        let (inside, beyond) = row.as_chunks_mut().0.split_at_mut(columns);
        inside.copy_from_slice(from);
        beyond.fill(from[columns - 1]);
    });
    AnyTensor::F32(map)
}

/// Copies the top left of `map` to `frame`, clamped to 0…1.
pub fn crop(map: &Tensor, frame: &mut Frame) {
    let width = frame.size().width as usize;
    frame.pixels_mut().par_chunks_exact_mut(width).enumerate().for_each(|(y, row)| show(map.row(y), row));
}

/// Copies the first pixels of a `row` of a picture to `to`, clamped to 0…1.
pub fn show(row: &[f32], to: &mut [[f32; 4]]) {
    for (to, &[r, g, b]) in to.iter_mut().zip(row.as_chunks().0) {
        *to = [r.clamp(0.0, 1.0), g.clamp(0.0, 1.0), b.clamp(0.0, 1.0), 1.0];
    }
}
