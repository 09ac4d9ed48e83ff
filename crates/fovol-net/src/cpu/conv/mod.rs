//! Convolutions: patches of the inputs, weights in the order of their use, and a block of pixels × channels at a
//! time in registers.

#[cfg(target_arch = "x86_64")]
pub(super) mod avx2;
#[cfg(target_arch = "x86_64")]
pub(super) mod avx512;
mod packed;
pub(super) mod portable;

use super::map::Map;
use super::patch::{Source, Window, assemble};
use super::simd::Simd;
use crate::plan::{Activation, Padding, Resize};
use packed::Packed;
use rayon::prelude::*;

/// A convolution with its weights, prepared for one instruction set.
#[derive(Debug, Clone)]
pub struct PreparedConv {
    packed: Packed,
    inputs: usize,
    outputs: usize,
    size: usize,
    stride: usize,
    padding: Padding,
    activation: Activation,
    simd: Simd,
}

/// The shape of a convolution.
#[derive(Debug, Clone, Copy)]
pub struct ConvShape {
    /// Channels that come in.
    pub inputs: usize,
    /// Channels that go out.
    pub outputs: usize,
    /// 1 or 3.
    pub size: usize,
    /// 1 or 2.
    pub stride: usize,
    /// What lies beyond the border.
    pub padding: Padding,
    /// What follows.
    pub activation: Activation,
}

/// Output rows that are made from one patch.
const ROWS: usize = 8;
/// About as many bytes may a patch have: half of a second-level cache.
const PATCH_BYTES: usize = 384 << 10;

/// One call of a kernel: a group of pixels side by side, all from one patch.
#[derive(Debug, Clone, Copy)]
pub(super) struct Call {
    /// The first number of the first window.
    patch: *const f32,
    /// From one row of the patch to the next.
    row: usize,
    /// From the window of one pixel to that of the next.
    pixel: usize,
    /// Rows of a window.
    rows: usize,
    /// Numbers of a window's row, which lie together.
    run: usize,
    /// Weights of a block: \[row\]\[number of the run\]\[channel of the block\].
    weights: *const f32,
    /// A number for each channel of the block.
    bias: *const f32,
}

/// Runs `call` and writes pixels × block width to `out`, pixel by pixel.
pub(super) type Kernel = unsafe fn(call: &Call, out: *mut f32);

impl PreparedConv {
    /// A convolution of `shape` with `weights` \[out, in, size, size\] and `bias` \[out\].
    pub fn new(shape: &ConvShape, weights: &[f32], bias: &[f32], simd: Simd) -> Self {
        Self {
            packed: Packed::new(shape, weights, bias, simd),
            inputs: shape.inputs,
            outputs: shape.outputs,
            size: shape.size,
            stride: shape.stride,
            padding: shape.padding,
            activation: shape.activation,
            simd,
        }
    }

    /// Rows and columns of what comes of `sources`.
    fn output_size(&self, sources: &[Source<'_>]) -> [usize; 2] {
        sources[0].size().map(|side| side.div_ceil(self.stride))
    }

    /// Writes the convolution of the concatenated `sources` to `out`, whose buffer is used again.
    pub fn run(&self, sources: &[Source<'_>], out: &mut Map) {
        let [height, width] = self.output_size(sources);
        debug_assert_eq!(self.inputs, sources.iter().map(|source| source.map.channels).sum::<usize>());
        out.data.resize(height * width * self.outputs, 0.0);
        (out.height, out.width, out.channels) = (height, width, self.outputs);
        let columns = self.tile_columns(width);
        let length = width * self.outputs;
        let bands = out.data.par_chunks_mut(ROWS * length).enumerate();
        bands.for_each_init(Scratch::default, |scratch, (band, out)| {
            let rows = out.len() / length;
            for x in (0..width).step_by(columns) {
                let tile = Tile { y: band * ROWS, x, rows, columns: columns.min(width - x) };
                self.tile(sources, tile, scratch, out, width);
            }
        });
    }

    /// Writes `rows` rows from `y` on of what comes of `source` to `out`, on this thread alone.
    pub fn run_rows(&self, source: &Map, y: usize, rows: usize, out: &mut Map) {
        let sources = [Source { map: source, resize: Resize::Same }];
        let width = source.width.div_ceil(self.stride);
        let columns = self.tile_columns(width);
        out.data.resize(rows * width * self.outputs, 0.0);
        (out.height, out.width, out.channels) = (rows, width, self.outputs);
        let mut scratch = Scratch::default();
        for (band, out) in out.data.chunks_mut(ROWS * width * self.outputs).enumerate() {
            let rows = out.len() / (width * self.outputs);
            for x in (0..width).step_by(columns) {
                let tile = Tile { y: y + band * ROWS, x, rows, columns: columns.min(width - x) };
                self.tile(&sources, tile, &mut scratch, out, width);
            }
        }
    }

    /// Columns of a tile: whole groups of pixels, as many as a patch has room for.
    fn tile_columns(&self, width: usize) -> usize {
        let group = self.simd.group();
        let per_column = (ROWS * self.stride + self.size) * self.stride * self.inputs * size_of::<f32>();
        let most = (PATCH_BYTES / per_column / group).max(1);
        // Tiles of much the same width.
        let groups = width.div_ceil(group);
        groups.div_ceil(groups.div_ceil(most)) * group
    }

    fn tile(&self, sources: &[Source<'_>], tile: Tile, scratch: &mut Scratch, out: &mut [f32], width: usize) {
        let group = self.simd.group();
        let groups = tile.columns.div_ceil(group);
        let reach = (self.size / 2) as isize;
        let window = Window {
            y: (tile.y * self.stride) as isize - reach,
            x: (tile.x * self.stride) as isize - reach,
            rows: (tile.rows - 1) * self.stride + self.size,
            columns: (groups * group - 1) * self.stride + self.size,
        };
        assemble(sources, self.padding, window, self.inputs, &mut scratch.patch);
        let row = window.columns * self.inputs;
        let pixel = self.stride * self.inputs;
        for block in self.packed.blocks() {
            let channels = block.width.min(self.outputs - block.first);
            for y in 0..tile.rows {
                for g in 0..groups {
                    let start = y * self.stride * row + g * group * pixel;
                    let call = Call {
                        patch: scratch.patch[start..].as_ptr(),
                        row,
                        pixel,
                        rows: self.size,
                        run: self.size * self.inputs,
                        weights: block.weights.as_ptr(),
                        bias: block.bias.as_ptr(),
                    };
                    // SAFETY: the patch holds whole groups of windows; the block has as many numbers as the
                    // kernel writes; `simd` is only made where the processor has it.
                    unsafe { (block.kernel)(&call, scratch.block.as_mut_ptr()) };
                    let count = group.min(tile.columns - g * group);
                    let to = (y * width + tile.x + g * group) * self.outputs + block.first;
                    for p in 0..count {
                        let from = &scratch.block[p * block.width..][..channels];
                        activate(self.activation, from, &mut out[to + p * self.outputs..][..channels]);
                    }
                }
            }
        }
    }
}

/// Memory of one thread.
struct Scratch {
    patch: Vec<f32>,
    block: Vec<f32>,
}

impl Default for Scratch {
    fn default() -> Self {
        Self { patch: Vec::new(), block: vec![0.0; packed::LARGEST_BLOCK] }
    }
}

/// A part of the output.
#[derive(Debug, Clone, Copy)]
struct Tile {
    y: usize,
    x: usize,
    rows: usize,
    columns: usize,
}

#[inline]
fn activate(activation: Activation, from: &[f32], to: &mut [f32]) {
    match activation {
        Activation::None => to.copy_from_slice(from),
        Activation::Relu => to.iter_mut().zip(from).for_each(|(to, &v)| *to = v.max(0.0)),
        Activation::Elu => to.iter_mut().zip(from).for_each(|(to, &v)| *to = elu(v)),
    }
}

/// x for x > 0, else eˣ − 1.
#[inline]
pub fn elu(x: f32) -> f32 {
    if x > 0.0 { x } else { x.exp_m1() }
}

#[cfg(test)]
mod tests;
