//! Winograd convolution: 3×3 convolutions with 36 instead of 144 products for 4×4 outputs. This is F(4×4, 3×3) of
//! Lavin and Gray, "Fast Algorithms for Convolutional Neural Networks" (2016).
//!
//! Every 6×6 of inputs is transformed to BᵀdB and multiplied by the transformed weights GgGᵀ. Summing over input
//! channels is a matrix product for each of the 36 places. AᵀmA transforms the sums back to 4×4 outputs. All
//! arithmetic is f32, except that transformed inputs and weights may be rounded to bf16 or to bytes.

mod back;
mod bytes;
mod forward;
mod parts;
mod reach;
mod tile;
mod words;

use super::call::Call;
use super::kernels::{self, OutputBlock};
use super::shape::{Arithmetic, ConvShape, check};
use super::words::{word_of_bf16, word_of_bytes, word_of_f32};
use crate::cpu::conv::pack::Floats;
use crate::cpu::conv::patch::{Access, Source, Window};
use crate::cpu::tensor::element::Element;
use crate::cpu::tensor::rows::View;
pub use parts::{Scratch, Winograd};
pub use reach::{Distances, note_transformed};

use back::TransformBack;
use bytes::Bytes;
use forward::Transform;
use fovol_simd::{Bf16, Simd};
use parts::{Block, Factors, Strip};
use tile::{PLACES, SIDE};
use words::WORDS;

/// Output rows of one patch. Each patch assembles two rows again that its neighbours have too.
const ROWS: usize = 12;
/// Approximate bytes of a patch, its transformed inputs and their products, which leaves room for weights in the
/// second-level cache.
const BYTES: usize = 320 << 10;

/// Fewest products per pixel and place for which the transforms pay; for f32 half as many suffice.
const FEWEST_PRODUCTS: usize = 448;

impl Winograd {
    /// Whether Winograd's algorithm is faster for a convolution of `shape` with `arithmetic` on `simd`.
    pub fn suits(shape: &ConvShape, simd: Simd, arithmetic: &Arithmetic) -> bool {
        let is_known = match arithmetic {
            Arithmetic::F32 => true,
            // AMX multiplies so fast that the transforms would take longer.
            Arithmetic::Bf16 => !kernels::multiplies_tiles(simd, arithmetic),
            Arithmetic::Int8 { reach, .. } => {
                let is_known = reach.as_ref().is_some_and(|reach| reach.len() == PLACES * shape.inputs);
                // AVX2 has no byte versions of the transforms yet, and plain code would be slower than the direct
                // convolution.
                is_known && matches!(simd, Simd::Avx512 { .. } | Simd::Portable)
            }
            Arithmetic::SplitBf16 => false,
        };
        let pays = shape.inputs * shape.outputs * 2 >= FEWEST_PRODUCTS * arithmetic.count();
        is_known && shape.size == 3 && shape.stride == 1 && pays
    }

    /// Prepares a convolution of `shape` with `weights` \[out, in, 3, 3\] and `bias` \[out\].
    pub fn new(
        shape: &ConvShape,
        weights: &[f32],
        bias: &[f32],
        simd: Simd,
        arithmetic: &Arithmetic,
    ) -> Self {
        let factors = match arithmetic {
            Arithmetic::F32 => Factors::F32,
            Arithmetic::Int8 { reach: Some(reach), .. } => Factors::Bytes(Bytes::new(shape.inputs, reach)),
            _ => Factors::Bf16,
        };
        let has_kernels = match factors {
            Factors::F32 => true,
            Factors::Bf16 => simd.has_bf16(),
            Factors::Bytes(_) => simd.has_int8(),
        };
        let simd = if has_kernels { simd } else { Simd::Portable };
        let transformed: Vec<_> = weights.chunks_exact(9).map(tile::weights).collect();
        let prepared = |OutputBlock { first, width, channels, bias, kernel }: OutputBlock| {
            let kernels = &transformed[channels.start * shape.inputs..channels.end * shape.inputs];
            let bias_of_tile = bias.repeat(SIDE * SIDE);
            let (weights, worth, bias) = match &factors {
                Factors::F32 => (packed(kernels, shape.inputs, width, word_of_f32), None, bias_of_tile),
                Factors::Bf16 => (packed(kernels, shape.inputs, width, word_of_bf16), None, bias_of_tile),
                Factors::Bytes(bytes) => {
                    let quantised = bytes.quantised(kernels, width);
                    let weights = packed(&quantised.kernels, shape.inputs, width, word_of_bytes);
                    let bias = quantised.bias(&bias);
                    (weights, Some(quantised.worth), bias)
                }
            };
            Block { first, width, weights: weights.into(), worth, bias, kernel }
        };
        let blocks = kernels::output_blocks(simd, arithmetic, bias).into_iter().map(prepared).collect();
        Self { blocks, shape: *shape, factors, simd }
    }

    /// Writes the output rows from `y` on to `out`.
    pub fn rows<T: Element>(&self, sources: &[Source<'_>], y: usize, scratch: &mut Scratch, out: &mut [T]) {
        check(&self.shape, sources);
        let sources = &self.in_place(sources)[..];
        let width = sources[0].size()[1];
        let row = width * self.shape.outputs;
        for (band, out) in out.chunks_mut(ROWS * row).enumerate() {
            let rows = (out.len() / row).next_multiple_of(SIDE);
            let tiles = self.strip_tiles(rows, width);
            for x in (0..width).step_by(SIDE * tiles) {
                let window = Window {
                    y: (y + band * ROWS) as isize - 1,
                    x: x as isize - 1,
                    rows: rows + 2,
                    columns: SIDE * tiles + 2,
                };
                self.load(sources, window, scratch);
                for (number, out) in out.chunks_mut(SIDE * row).enumerate() {
                    let row = SIDE * number;
                    let strip = Strip { place: [y + band * ROWS + row, x], row, tiles };
                    self.simd.in_vectors(Transform { conv: self, sources, strip, scratch });
                    for block in &self.blocks {
                        self.multiply(block, strip, scratch);
                        self.simd.in_vectors(TransformBack { conv: self, block, strip, scratch, out, width });
                    }
                }
            }
        }
    }

    /// Number of tiles side by side in `rows` output rows: whole groups, as many as [`BYTES`] allow.
    fn strip_tiles(&self, rows: usize, width: usize) -> usize {
        let group = self.group();
        let words = PLACES * (self.pixel() + self.blocks[0].width) + (rows + 2) * SIDE * self.loaded_pixel();
        let most = (BYTES / (words * size_of::<u32>() * group)).max(1);
        let groups = width.div_ceil(SIDE).div_ceil(group);
        groups.div_ceil(groups.div_ceil(most)) * group
    }

    /// Returns `sources`, with [`Access::InPlace`] for those whose memory layout suits vector loads.
    fn in_place<'a>(&self, sources: &[Source<'a>]) -> Vec<Source<'a>> {
        let whole = WORDS * self.factors.loaded();
        let mut first = 0usize;
        let access = |source: &Source<'a>| {
            let is_alike = matches!(
                (&source.rows, &self.factors),
                (View::F32(_), Factors::F32) | (View::Bf16(_), Factors::Bf16 | Factors::Bytes(_))
            );
            let is_aligned = first.is_multiple_of(whole) && source.channels().is_multiple_of(whole);
            first += source.channels();
            if is_alike && is_aligned && source.access == Access::SAME {
                Access::InPlace
            } else {
                source.access
            }
        };
        sources
            .iter()
            .zip(sources.iter().map(access))
            .map(|(source, access)| Source { access, ..*source })
            .collect()
    }

    /// Assembles the patch of a strip, except for sources that are read in place.
    fn load(&self, sources: &[Source<'_>], window: Window, scratch: &mut Scratch) {
        if sources.iter().all(|source| source.access == Access::InPlace) {
            return;
        }
        let (patch, padding, pixel) = (&mut scratch.patch, self.shape.padding, self.loaded_pixel());
        match self.factors {
            Factors::F32 => {
                patch.assemble(sources, padding, window, (Floats::<f32>::default(), pixel, self.simd));
            }
            Factors::Bf16 | Factors::Bytes(_) => {
                patch.assemble(sources, padding, window, (Floats::<Bf16>::default(), pixel, self.simd));
            }
        }
    }

    /// Sums the products over the input channels: a matrix product for each place.
    fn multiply(&self, block: &Block, strip: Strip, scratch: &mut Scratch) {
        const NO_BIAS: [f32; 32] = [0.0; 32];
        let (group, pixel, words) = (self.group(), self.pixel(), self.words());
        let Scratch { transformed, products, .. } = scratch;
        let products: &mut [f32] = products.numbers(PLACES * strip.tiles * block.width);
        for place in 0..PLACES {
            let weights = block.weights[place * words * block.width..].as_ptr();
            for tile in (place * strip.tiles..(place + 1) * strip.tiles).step_by(group) {
                let call = Call {
                    patch: transformed[tile * pixel..].as_ptr(),
                    row: 0,
                    pixel,
                    rows: 1,
                    run: words,
                    weights,
                    bias: NO_BIAS.as_ptr(),
                };
                // SAFETY: strips are whole groups of tiles, and kernels are only chosen where the processor has
                // their instructions.
                unsafe { (block.kernel)(&call, products[tile * block.width..].as_mut_ptr()) };
            }
        }
    }
}

/// Packs transformed `kernels` \[channel of the block, in\] for a block of `width` channels. `word` packs `COUNT`
/// inputs into one word.
fn packed<const COUNT: usize>(
    kernels: &[[f32; PLACES]],
    inputs: usize,
    width: usize,
    word: impl Fn([f32; COUNT]) -> u32,
) -> Vec<u32> {
    let words = inputs.div_ceil(COUNT);
    let mut packed = vec![0u32; PLACES * words * width];
    for (channel, kernels) in kernels.chunks_exact(inputs).enumerate() {
        for (number, kernels) in kernels.chunks(COUNT).enumerate() {
            for place in 0..PLACES {
                let values = std::array::from_fn(|at| kernels.get(at).map_or(0.0, |kernel| kernel[place]));
                packed[(place * words + number) * width + channel] = word(values);
            }
        }
    }
    packed
}
