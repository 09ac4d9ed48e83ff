//! Converts frames to the maps that networks read, and back.

use crate::cpu::tensor::samples::{Sample, Samples};
use crate::cpu::tensor::{AnyTensor, Tensor};
use fovol_core::{Frame, FrameSize};
use rayon::prelude::*;

/// Image of the colours of `samples`, 0 between them.
pub fn colours_of(samples: &Samples, map: Tensor) -> AnyTensor {
    scattered(samples, map, 3, |sample, to| to.copy_from_slice(&sample.colour))
}

/// Image with 1 at `samples` and 0 elsewhere.
pub fn weights_of(samples: &Samples, map: Tensor) -> AnyTensor {
    scattered(samples, map, 1, |_, to| to.fill(1.0))
}

/// Image of `channels` that is 0 except where `put` writes a sample.
fn scattered(
    samples: &Samples,
    mut map: Tensor,
    channels: usize,
    put: impl Fn(&Sample, &mut [f32]) + Sync,
) -> AnyTensor {
    let [height, width] = samples.size();
    map.resize([height, width, channels]);
    map.data.par_chunks_exact_mut(width * channels).enumerate().for_each(|(y, row)| {
        row.fill(0.0);
        for sample in samples.row(y) {
            put(sample, &mut row[sample.x as usize * channels..][..channels]);
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
