//! Direct convolutions.

#[cfg(target_arch = "x86_64")]
use super::amx;
use super::call::Call;
use super::finish::Finish;
use super::kernels;
use super::pack::{Bytes, Floats};
use super::packed::{self, Packed};
use super::patch::{Patch, Source, Window};
use super::shape::{Arithmetic, ConvShape, ROWS, check};
use crate::cpu::tensor::element::Element;
use bytemuck::cast_slice;
use fovol_simd::{AlignedBuf, Bf16, Simd};

/// Approximate bytes of a patch: half of a second-level cache.
const PATCH_BYTES: usize = 384 << 10;

/// Direct convolution: assembles patches, and computes a block of pixels × channels at a time in registers.
#[derive(Debug, Clone)]
pub struct Direct {
    pub packed: Packed,
    pub shape: ConvShape,
    pub arithmetic: Arithmetic,
    pub group: usize,
    pub simd: Simd,
}

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
    pub fn rows<T: Element>(
        &self,
        sources: &[Source<'_>],
        y: usize,
        scratch: &mut DirectScratch,
        out: &mut [T],
    ) {
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

    /// Words of a pixel.
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
            Arithmetic::F32 => {
                patch.assemble(sources, padding, window, (Floats::<f32>::default(), words, simd));
            }
            Arithmetic::Bf16 | Arithmetic::SplitBf16 => {
                patch.assemble(sources, padding, window, (Floats::<Bf16>::default(), words, simd));
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

/// Scratch memory of one thread.
#[derive(Debug, Default)]
pub struct DirectScratch {
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
