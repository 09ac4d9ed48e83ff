//! Convolutions. Inputs are assembled to patches, weights are packed in the order of use, and kernels keep a block
//! of pixels × channels in registers.

#[cfg(target_arch = "x86_64")]
pub(super) mod amx;
#[cfg(target_arch = "x86_64")]
pub(super) mod avx2;
#[cfg(target_arch = "x86_64")]
pub(super) mod avx512;
mod finish;
pub(super) mod kernels;
mod narrow;
mod packed;
pub(super) mod portable;
mod winograd;

use super::element::Element;
use super::pack::{Bytes, Halves, Singles};
use super::patch::{Patch, Source, Window};
use super::prediction::Chunk;
use super::tensor::Tensor;
use crate::plan::{Activation, Padding};
use bytemuck::cast_slice;
use finish::Finish;
pub use finish::elu;
use fovol_simd::{AlignedBuf, Bf16, Simd};
use narrow::Narrow;
use packed::Packed;
use rayon::prelude::*;
use winograd::Winograd;
pub use winograd::{Distances, note_transformed};

/// A convolution with its weights, prepared for one instruction set.
#[derive(Debug, Clone)]
pub enum PreparedConv {
    /// Direct convolution.
    Direct(Direct),
    /// Winograd convolution, with fewer products.
    Winograd(Winograd),
    /// 1×1 convolution with few outputs.
    Narrow(Narrow),
    /// Direct convolution that reads its inputs twice, with the upper and the lower bf16 of each weight.
    Split(Direct),
}

impl PreparedConv {
    /// Prepares a convolution of `shape` with `weights` \[out, in, size, size\] and `bias` \[out\].
    pub fn new(shape: &ConvShape, weights: &[f32], bias: &[f32], simd: Simd, arithmetic: Arithmetic) -> Self {
        if Winograd::suits(shape, simd, &arithmetic) {
            Self::Winograd(Winograd::new(shape, weights, bias, simd, &arithmetic))
        } else if arithmetic == Arithmetic::SplitBf16 {
            let twice = ConvShape { inputs: 2 * shape.inputs, ..*shape };
            Self::Split(Direct::new(&twice, &split(shape, weights), bias, simd, Arithmetic::Bf16))
        } else {
            let is_narrow = arithmetic == Arithmetic::F32 && Narrow::suits(shape);
            let direct = Direct::new(shape, weights, bias, simd, arithmetic);
            match is_narrow {
                true => Self::Narrow(Narrow::new(direct, weights, bias, simd)),
                false => Self::Direct(direct),
            }
        }
    }

    fn shape(&self) -> &ConvShape {
        match self {
            Self::Direct(conv) | Self::Split(conv) => &conv.shape,
            Self::Winograd(conv) => conv.shape(),
            Self::Narrow(conv) => &conv.direct.shape,
        }
    }

    /// Number of output channels.
    pub fn outputs(&self) -> usize {
        self.shape().outputs
    }

    /// Writes the convolution of the concatenated `sources` to `out`, whose buffer is reused.
    ///
    /// # Panics
    /// When the sources have not as many channels as the weights.
    pub fn run<T: Element>(&self, sources: &[Source<'_>], out: &mut Tensor<T>) {
        let ConvShape { stride, outputs, .. } = *self.shape();
        let [height, width] = sources[0].size().map(|side| side.div_ceil(stride));
        out.resize([height, width, outputs]);
        let bands = out.data.par_chunks_mut(ROWS * width * outputs).enumerate();
        bands.for_each_init(Scratch::default, |scratch, (band, out)| {
            self.rows(sources, band * ROWS, scratch, out);
        });
    }

    /// Writes output rows from `y` on to `out`, as many as fit.
    ///
    /// # Panics
    /// When the sources have not as many channels as the weights.
    pub fn rows<T: Element>(&self, sources: &[Source<'_>], y: usize, scratch: &mut Scratch, out: &mut [T]) {
        match self {
            Self::Direct(conv) => conv.rows(sources, y, &mut scratch.direct, out),
            Self::Winograd(conv) => conv.rows(sources, y, &mut scratch.winograd, out),
            Self::Narrow(conv) => {
                if !conv.rows(sources, y, &mut scratch.chunk, out) {
                    conv.direct.rows(sources, y, &mut scratch.direct, out);
                }
            }
            Self::Split(conv) => conv.rows(&[sources, sources].concat(), y, &mut scratch.direct, out),
        }
    }
}

/// Splits `weights` \[out, in, size, size\] into sums of two bf16. For each output the upper parts of all inputs
/// come first, then the lower ones.
fn split(shape: &ConvShape, weights: &[f32]) -> Vec<f32> {
    let mut halves = Vec::with_capacity(2 * weights.len());
    for weights in weights.chunks_exact(shape.inputs * shape.size * shape.size) {
        let upper = weights.iter().map(|&w| Bf16::from_f32(w).to_f32());
        halves.extend(upper.clone());
        halves.extend(weights.iter().zip(upper).map(|(w, upper)| w - upper));
    }
    halves
}

/// Scratch memory of one thread.
#[derive(Debug, Default)]
pub struct Scratch {
    direct: DirectScratch,
    winograd: winograd::Scratch,
    chunk: Chunk,
}

/// Direct convolution: assembles patches, and computes a block of pixels × channels at a time in registers.
#[derive(Debug, Clone)]
pub struct Direct {
    packed: Packed,
    shape: ConvShape,
    arithmetic: Arithmetic,
    group: usize,
    simd: Simd,
}

/// Type of the factors of products. Sums are f32, or 32-bit integers for int8.
#[derive(Debug, Clone, PartialEq)]
pub enum Arithmetic {
    /// f32 × f32.
    F32,
    /// bf16 × bf16, in pairs.
    Bf16,
    /// bf16 × sum of two bf16, which has nearly the precision of f32. For inputs that are stored as bf16.
    SplitBf16,
    /// Unsigned × signed bytes, in quadruples, with a step for each input channel.
    Int8 {
        /// Step of each input channel: values are byte · step.
        steps: Vec<f32>,
        /// Ranges of transformed inputs for Winograd's tiles, \[place\]\[channel\]; `None` where they are unknown.
        reach: Option<Vec<f32>>,
    },
}

impl Arithmetic {
    /// Number of elements in a 32-bit word.
    pub fn count(&self) -> usize {
        match self {
            Self::F32 => 1,
            Self::Bf16 | Self::SplitBf16 => 2,
            Self::Int8 { .. } => 4,
        }
    }
}

/// Shape of a convolution.
#[derive(Debug, Clone, Copy)]
pub struct ConvShape {
    /// Number of input channels.
    pub inputs: usize,
    /// Number of output channels.
    pub outputs: usize,
    /// Edge of the window in pixels: 1 or 3.
    pub size: usize,
    /// Step between windows in pixels: 1 or 2.
    pub stride: usize,
    /// Values beyond the border.
    pub padding: Padding,
    /// Activation function.
    pub activation: Activation,
}

/// Output rows of one patch.
const ROWS: usize = 8;
/// Approximate bytes of a patch: half of a second-level cache.
const PATCH_BYTES: usize = 384 << 10;

/// Arguments of a kernel, for a group of neighbouring pixels of one patch. Lengths are in 32-bit words.
#[derive(Debug, Clone, Copy)]
pub(super) struct Call {
    /// First word of the first window.
    patch: *const u32,
    /// Distance between rows of the patch.
    row: usize,
    /// Distance between the windows of neighbouring pixels.
    pixel: usize,
    /// Rows of a window.
    rows: usize,
    /// PageBuf of a window's row, which are contiguous.
    run: usize,
    /// Weights of a block: \[row\]\[word of the run\]\[channel of the block\].
    weights: *const u32,
    /// Initial value of sums, for each channel of the block. Sums of bytes start from zero.
    bias: *const f32,
}

/// A kernel: computes the sums of a call, and writes pixels × block width to its second argument, pixel by pixel.
/// Sums are 32-bit integers for int8, else f32.
pub(super) type Kernel = unsafe fn(call: &Call, out: *mut f32);

impl Direct {
    /// Prepares a convolution of `shape` with `weights` \[out, in, size, size\] and `bias` \[out\].
    pub fn new(shape: &ConvShape, weights: &[f32], bias: &[f32], simd: Simd, arithmetic: Arithmetic) -> Self {
        let has_kernels = match arithmetic {
            Arithmetic::F32 => true,
            Arithmetic::Bf16 | Arithmetic::SplitBf16 => simd.has_bf16(),
            Arithmetic::Int8 { .. } => simd.has_int8(),
        };
        let simd = if has_kernels { simd } else { Simd::Portable };
        Self {
            packed: Packed::new(shape, weights, bias, simd, &arithmetic),
            shape: *shape,
            group: kernels::group(simd, &arithmetic),
            simd,
            arithmetic: match arithmetic {
                // Inputs are multiplied by the inverse steps.
                Arithmetic::Int8 { mut steps, reach } => {
                    steps.iter_mut().for_each(|step| *step = 1.0 / *step);
                    Arithmetic::Int8 { steps, reach }
                }
                other => other,
            },
        }
    }

    /// Writes the output rows from `y` on to `out`.
    fn rows<T: Element>(&self, sources: &[Source<'_>], y: usize, scratch: &mut DirectScratch, out: &mut [T]) {
        check(&self.shape, sources);
        // SAFETY: AMX kernels are only chosen where tiles are granted.
        #[cfg(target_arch = "x86_64")]
        let _tiles =
            kernels::multiplies_tiles(self.simd, &self.arithmetic).then(|| unsafe { amx::Tiles::new() });
        let width = sources[0].size()[1].div_ceil(self.shape.stride);
        let length = width * self.shape.outputs;
        let columns = self.tile_columns(width);
        for (band, out) in out.chunks_mut(ROWS * length).enumerate() {
            let (y, rows) = (y + band * ROWS, out.len() / length);
            for x in (0..width).step_by(columns) {
                let tile = Tile { y, x, rows, columns: columns.min(width - x) };
                self.tile(sources, tile, scratch, out, width);
            }
        }
    }

    /// PageBuf of a pixel.
    fn words(&self) -> usize {
        self.shape.inputs.div_ceil(self.arithmetic.count())
    }

    /// Columns of a tile: whole groups of pixels, as many as [`PATCH_BYTES`] allow.
    fn tile_columns(&self, width: usize) -> usize {
        let ConvShape { size, stride, .. } = self.shape;
        let per_column = (ROWS * stride + size) * stride * self.words() * size_of::<u32>();
        let most = (PATCH_BYTES / per_column / self.group).max(1);
        // Columns are divided evenly among tiles.
        let groups = width.div_ceil(self.group);
        groups.div_ceil(groups.div_ceil(most)) * self.group
    }

    /// Computes `tile` of the output. `out` has all `width` columns of its rows.
    fn tile<T: Element>(
        &self,
        sources: &[Source<'_>],
        tile: Tile,
        scratch: &mut DirectScratch,
        out: &mut [T],
        width: usize,
    ) {
        let ConvShape { size, stride, outputs, .. } = self.shape;
        let groups = tile.columns.div_ceil(self.group);
        let reach = (size / 2) as isize;
        let window = Window {
            y: (tile.y * stride) as isize - reach,
            x: (tile.x * stride) as isize - reach,
            rows: (tile.rows - 1) * stride + size,
            columns: (groups * self.group - 1) * stride + size,
        };
        let (patch, padding) = (&mut scratch.patch, self.shape.padding);
        let (words, simd) = (self.words(), self.simd);
        match &self.arithmetic {
            Arithmetic::F32 => patch.assemble(sources, padding, window, (Singles, words, simd)),
            Arithmetic::Bf16 | Arithmetic::SplitBf16 => {
                patch.assemble(sources, padding, window, (Halves, words, simd));
            }
            Arithmetic::Int8 { steps, .. } => {
                patch.assemble(sources, padding, window, (Bytes(steps), words, simd));
            }
        }
        scratch.block.resize(packed::LARGEST_BLOCK);
        let row = window.columns * self.words();
        let pixel = stride * self.words();
        for block in self.packed.blocks() {
            for y in 0..tile.rows {
                for g in 0..groups {
                    let start = y * stride * row + g * self.group * pixel;
                    let call = Call {
                        patch: scratch.patch.words[start..].as_ptr(),
                        row,
                        pixel,
                        rows: size,
                        run: size * self.words(),
                        weights: block.weights.as_ptr(),
                        bias: block.bias.as_ptr(),
                    };
                    // SAFETY: the patch holds whole groups of windows, the block has room for all sums of the
                    // kernel, and kernels are only chosen where the processor has their instructions.
                    unsafe { (block.kernel)(&call, scratch.block.as_mut_ptr().cast()) };
                    let to = (y * width + tile.x + g * self.group) * outputs + block.first;
                    simd.vectorised(Finish {
                        sums: cast_slice(&scratch.block),
                        width: block.width,
                        worth: block.worth.as_ref(),
                        activation: self.shape.activation,
                        pixels: self.group.min(tile.columns - g * self.group),
                        channels: block.width.min(outputs - block.first),
                        out: &mut out[to..],
                        stride: outputs,
                    });
                }
            }
        }
    }
}

/// Checks the number of channels.
///
/// # Panics
/// When the sources have not as many channels as the weights.
fn check(shape: &ConvShape, sources: &[Source<'_>]) {
    let inputs: usize = sources.iter().map(|source| source.channels()).sum();
    assert_eq!(shape.inputs, inputs, "a convolution reads what its weights are for");
}

/// Scratch memory of one thread.
#[derive(Debug, Default)]
struct DirectScratch {
    patch: Patch,
    block: AlignedBuf,
}

/// Part of the output.
#[derive(Debug, Clone, Copy)]
struct Tile {
    y: usize,
    x: usize,
    rows: usize,
    columns: usize,
}

#[cfg(test)]
mod tests;
