//! How far transformed inputs reach, for bytes.

use super::forward::Transform;
use super::tile::{self, PLACES, REACH, SIDE};
use super::{Scratch, Strip, Winograd};
use crate::cpu::conv::{Arithmetic, ConvShape};
use crate::cpu::patch::{Source, Window};
use crate::cpu::simd::Simd;
use crate::plan::{Activation, Padding};
use bytemuck::cast_slice;

/// How far transformed numbers are from 0 in each place, as a part of how far they could be.
pub type Reach = [f32; PLACES];

/// Makes each number of `most` \[place\]\[channel\], which may be empty yet, what transformed numbers of the concatenated `sources`
/// reach there, if that is more.
pub fn furthest_transformed(sources: &[Source<'_>], padding: Padding, most: &mut Vec<f32>) {
    let inputs = sources.iter().map(Source::channels).sum();
    let shape = ConvShape { inputs, outputs: 1, size: 3, stride: 1, padding, activation: Activation::None };
    let conv = Winograd::new(&shape, &vec![0.0; 9 * inputs], &[0.0], Simd::Portable, &Arithmetic::F32);
    most.resize(PLACES * inputs, 0.0);
    let [height, width] = sources[0].size();
    let (tiles, pixel) = (conv.strip_tiles(SIDE, width), conv.pixel());
    let mut scratch = Scratch::default();
    for (y, x) in
        (0..height).step_by(SIDE).flat_map(|y| (0..width).step_by(SIDE * tiles).map(move |x| (y, x)))
    {
        let strip = Strip { place: [y, x], row: 0, tiles };
        conv.load(
            sources,
            Window { y: y as isize - 1, x: x as isize - 1, rows: REACH, columns: SIDE * tiles + 2 },
            &mut scratch,
        );
        conv.simd.in_vectors(Transform { conv: &conv, sources, strip, scratch: &mut scratch });
        let transformed: &[f32] = cast_slice(&scratch.transformed);
        for (most, tiles) in most.chunks_exact_mut(inputs).zip(transformed.chunks_exact(tiles * pixel)) {
            for tile in tiles.chunks_exact(pixel) {
                most.iter_mut().zip(tile).for_each(|(most, v)| *most = most.max(v.abs()));
            }
        }
    }
}

/// How far `most` \[place\]\[channel\], where inputs are never further from 0 than `ranges`.
pub fn reach(most: &[f32], ranges: &[f32]) -> Vec<f32> {
    let of_place = |(place, most): (usize, &[f32])| {
        let parts = most.iter().zip(ranges).map(|(most, range)| most / (range * tile::furthest(place)));
        parts.fold(1e-3, f32::max)
    };
    most.chunks_exact(ranges.len()).enumerate().map(of_place).collect()
}
