//! 3×3 convolutions with 36 instead of 144 products for 4×4 outputs: F(4×4, 3×3) of Lavin and Gray, "Fast Algorithms
//! for Convolutional Neural Networks" (2016), after Winograd.
//!
//! Every 6×6 of inputs is transformed to BᵀdB, multiplied with the transformed weights GgGᵀ and summed over the input
//! channels, which is a matrix product for each of the 36 places, and transformed back to 4×4 outputs by AᵀmA. All of it
//! is f32, but that transformed inputs and weights may be rounded to bf16 or to bytes.

mod bytes;
mod tile;

use super::finish::finish;
use super::{Arithmetic, Call, ConvShape, Kernel, check};
use crate::cpu::element::{Bf16, Element};
use crate::cpu::floats::{Floats, VectorWork};
use crate::cpu::lines::Lines;
use crate::cpu::pack::{Halves, Singles};
use crate::cpu::patch::{Patch, Source, Window};
use crate::cpu::simd::Simd;
use crate::plan::{Activation, Padding};
use bytemuck::{cast_slice, cast_slice_mut};
use bytes::Bytes;
use tile::{PLACES, REACH, SIDE};

/// Channels are padded to as many words: the longest vectors.
const WORDS: usize = 16;

/// Output rows that are made of one patch: of each other patch two rows are the same again.
const ROWS: usize = 12;
/// About as many bytes may a patch and its transformed inputs have: what stays in a second-level cache beside weights.
const BYTES: usize = 640 << 10;

/// Fewer products a pixel and place than this do not pay for the transformations; half as many f32 do.
const FEWEST_PRODUCTS: usize = 512;

/// A prepared convolution.
#[derive(Debug, Clone)]
pub struct Winograd {
    blocks: Vec<Block>,
    shape: ConvShape,
    factors: Factors,
    simd: Simd,
}

/// What is multiplied.
#[derive(Debug, Clone)]
enum Factors {
    Singles,
    /// Pairs of bf16.
    Halves,
    /// Fours of bytes, of inputs that are pairs of bf16.
    Bytes(Bytes),
}

impl Factors {
    fn arithmetic(&self) -> Arithmetic {
        match self {
            Self::Singles => Arithmetic::F32,
            Self::Halves => Arithmetic::Bf16,
            Self::Bytes(_) => Arithmetic::Int8 { steps: Vec::new(), reach: None },
        }
    }

    /// Transformed numbers in a word.
    fn count(&self) -> usize {
        self.arithmetic().count()
    }

    /// Inputs in a word of a patch.
    fn loaded(&self) -> usize {
        self.count().min(2)
    }
}

/// Some of the output channels.
#[derive(Debug, Clone)]
struct Block {
    first: usize,
    width: usize,
    /// \[place\]\[word of a pixel\]\[channel of the block\].
    weights: Lines,
    /// What sums of bytes are worth: \[place\]\[channel of the block\].
    worth: Option<Vec<f32>>,
    /// \[pixel of a tile\]\[channel of the block\].
    bias: Vec<f32>,
    kernel: Kernel,
}

/// Memory of one thread.
#[derive(Debug, Default)]
pub struct Scratch {
    /// \[row\]\[column\]\[word of a pixel\].
    patch: Patch,
    /// \[place\]\[tile\]\[word of a pixel\], with any words up to whole vectors of them.
    transformed: Lines,
    /// \[place\]\[tile\]\[channel of the block\].
    products: Lines,
}

/// A part of the output.
#[derive(Clone, Copy)]
struct Strip {
    /// Which row of the patch it begins with.
    row: usize,
    /// Its first column.
    x: usize,
    /// Tiles side by side, whole groups of them.
    tiles: usize,
}

impl Winograd {
    /// Whether `shape` is one that this is for, where `arithmetic` is that of `simd`.
    pub fn suits(shape: &ConvShape, simd: Simd, arithmetic: &Arithmetic) -> bool {
        let is_known = match arithmetic {
            Arithmetic::F32 => true,
            // Tiles multiply so fast that the transformations would take longer.
            Arithmetic::Bf16 => !simd.multiplies_tiles(arithmetic),
            Arithmetic::Int8 { reach, .. } => reach.is_some() && !simd.multiplies_tiles(arithmetic),
            Arithmetic::SplitBf16 => false,
        };
        let pays = shape.inputs * shape.outputs * 2 >= FEWEST_PRODUCTS * arithmetic.count();
        is_known && shape.size == 3 && shape.stride == 1 && pays
    }

    /// A convolution of `shape` with `weights` \[out, in, 3, 3\] and `bias` \[out\].
    pub fn new(
        shape: &ConvShape,
        weights: &[f32],
        bias: &[f32],
        simd: Simd,
        arithmetic: &Arithmetic,
    ) -> Self {
        let factors = match arithmetic {
            Arithmetic::F32 => Factors::Singles,
            Arithmetic::Int8 { steps, reach } => {
                Factors::Bytes(Bytes::new(steps, reach.as_ref().unwrap_or(&[1.0; PLACES])))
            }
            _ => Factors::Halves,
        };
        let has_kernels = match factors {
            Factors::Singles => true,
            Factors::Halves => simd.has_bf16(),
            Factors::Bytes(_) => simd.has_int8(),
        };
        let simd = if has_kernels { simd } else { Simd::Portable };
        let transformed: Vec<_> = weights.chunks_exact(9).map(tile::weights).collect();
        let mut blocks = Vec::new();
        let mut first = 0;
        while first < shape.outputs {
            let (width, kernel) = simd.block(shape.outputs - first, arithmetic);
            let channels = first..(first + width).min(shape.outputs);
            let kernels = &transformed[channels.start * shape.inputs..channels.end * shape.inputs];
            let bias: Vec<f32> =
                (first..first + width).map(|c| bias.get(c).copied().unwrap_or(0.0)).collect();
            let (weights, worth, bias) = match &factors {
                Factors::Singles => (
                    packed(kernels, shape.inputs, width, |one: [f32; 1]| one[0].to_bits()),
                    None,
                    bias.repeat(SIDE * SIDE),
                ),
                Factors::Halves => {
                    let pair = |pair: [f32; 2]| {
                        let [low, high] = pair.map(|v| u32::from(Bf16::from_f32(v).0));
                        low | high << 16
                    };
                    (packed(kernels, shape.inputs, width, pair), None, bias.repeat(SIDE * SIDE))
                }
                Factors::Bytes(bytes) => {
                    let quantised = bytes.quantised(kernels, width);
                    let four = |four: [f32; 4]| u32::from_le_bytes(four.map(|v| v as i8 as u8));
                    let weights = packed(&quantised.kernels, shape.inputs, width, four);
                    let bias = quantised.bias(&bias);
                    (weights, Some(quantised.worth), bias)
                }
            };
            blocks.push(Block { first, width, weights: weights.into(), worth, bias, kernel });
            first += width;
        }
        Self { blocks, shape: *shape, factors, simd }
    }

    /// Its shape.
    pub fn shape(&self) -> &ConvShape {
        &self.shape
    }

    /// Writes the rows from `y` on to `out`.
    pub fn rows<T: Element>(&self, sources: &[Source<'_>], y: usize, scratch: &mut Scratch, out: &mut [T]) {
        check(&self.shape, sources);
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
                    let strip = Strip { row: SIDE * number, x, tiles };
                    self.simd.in_vectors(Transform { conv: self, strip, scratch });
                    for block in &self.blocks {
                        self.multiply(block, strip, scratch);
                        self.simd.in_vectors(TransformBack { conv: self, block, strip, scratch, out, width });
                    }
                }
            }
        }
    }

    /// Words of a transformed pixel that there is something in.
    fn words(&self) -> usize {
        self.shape.inputs.div_ceil(self.factors.count())
    }

    /// Words of a pixel of the patch with those that there is nothing in.
    fn loaded_pixel(&self) -> usize {
        self.shape.inputs.div_ceil(self.factors.loaded()).next_multiple_of(WORDS)
    }

    /// The same of a transformed pixel.
    fn pixel(&self) -> usize {
        self.loaded_pixel() * self.factors.loaded() / self.factors.count()
    }

    /// Pixels that a kernel computes at once.
    fn group(&self) -> usize {
        self.simd.group(&self.factors.arithmetic())
    }

    /// Tiles side by side in `rows` rows of outputs: whole groups, as many as there is room for.
    fn strip_tiles(&self, rows: usize, width: usize) -> usize {
        let group = self.group();
        let words = PLACES * self.pixel() + (rows + 2) * SIDE * self.loaded_pixel();
        let most = (BYTES / (words * size_of::<u32>() * group)).max(1);
        let groups = width.div_ceil(SIDE).div_ceil(group);
        groups.div_ceil(groups.div_ceil(most)) * group
    }

    /// What tiles look at.
    fn load(&self, sources: &[Source<'_>], window: Window, scratch: &mut Scratch) {
        let (patch, padding, pixel) = (&mut scratch.patch, self.shape.padding, self.loaded_pixel());
        match self.factors {
            Factors::Singles => patch.assemble(sources, padding, window, (Singles, pixel, self.simd)),
            Factors::Halves | Factors::Bytes(_) => {
                patch.assemble(sources, padding, window, (Halves, pixel, self.simd))
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
                // SAFETY: strips are whole groups of tiles; kernels are only chosen where the processor has them.
                unsafe { (block.kernel)(&call, products[tile * block.width..].as_mut_ptr()) };
            }
        }
    }
}

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
        let strip = Strip { row: 0, x, tiles };
        conv.load(
            sources,
            Window { y: y as isize - 1, x: x as isize - 1, rows: REACH, columns: SIDE * tiles + 2 },
            &mut scratch,
        );
        conv.simd.in_vectors(Transform { conv: &conv, strip, scratch: &mut scratch });
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

/// The `kernels` \[channel of the block, in\], transformed, in the order of a block of `width` channels: as many inputs as are
/// in a word make one.
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

/// The making of BᵀdB of every tile and input channel.
struct Transform<'a> {
    conv: &'a Winograd,
    strip: Strip,
    scratch: &'a mut Scratch,
}

impl VectorWork for Transform<'_> {
    #[inline(always)]
    fn run<V: Floats>(self, some: V) {
        let Self { conv, strip, scratch } = self;
        scratch.transformed.resize(PLACES * strip.tiles * conv.pixel());
        let (patch, out) = (&scratch.patch.words[..], &mut scratch.transformed[..]);
        let pixel = conv.loaded_pixel();
        for word in (0..conv.shape.inputs.div_ceil(conv.factors.loaded())).step_by(V::N) {
            let part = Part { strip, pixel, word };
            match &conv.factors {
                Factors::Singles => {
                    let load = |at: usize| [some.load(cast_slice(&patch[at..at + V::N]))];
                    let mut store =
                        |_, at: usize, [v]: [V; 1]| v.store(cast_slice_mut(&mut out[at..at + V::N]));
                    transform(part, load, &mut store, some);
                }
                Factors::Halves => {
                    let load = |at: usize| some.load_halves(&patch[at..at + V::N]);
                    let mut store =
                        |_, at: usize, [low, high]: [V; 2]| low.store_halves(high, &mut out[at..at + V::N]);
                    transform(part, load, &mut store, some);
                }
                Factors::Bytes(bytes) => {
                    let load = |at: usize| some.load_halves(&patch[at..at + V::N]);
                    let out: &mut [u8] = cast_slice_mut(out);
                    let mut store = |place: usize, at: usize, values: [V; 2]| {
                        let factors = bytes.factors(place, word, V::N).map(|factors| some.load(factors));
                        V::store_bytes(
                            [values[0] * factors[0], values[1] * factors[1]],
                            &mut out[2 * at..2 * (at + V::N)],
                        );
                    };
                    transform(part, load, &mut store, some);
                }
            }
        }
    }
}

/// Some channels of the tiles of a strip.
#[derive(Clone, Copy)]
struct Part {
    strip: Strip,
    /// Words of a pixel.
    pixel: usize,
    /// Which word of each pixel they begin with.
    word: usize,
}

/// BᵀdB of some channels of every tile, as many as are in vectors of words, of which one `load`s and `store`s as many vectors
/// of numbers as are in them, the latter for a place. What lies beyond the last channel may be anything.
#[inline(always)]
fn transform<V: Floats, const PARTS: usize>(
    Part { strip: Strip { row: top, tiles, .. }, pixel, word }: Part,
    load: impl Fn(usize) -> [V; PARTS],
    store: &mut impl FnMut(usize, usize, [V; PARTS]),
    some: V,
) {
    let row = (SIDE * tiles + 2) * pixel;
    let mut columns = [[[some; REACH]; REACH]; PARTS];
    let mut first = 0;
    for tile in 0..tiles {
        // Two columns are those of the tile before.
        for column in first..REACH {
            let at = (SIDE * tile + column) * pixel + word;
            let mut d = [[some; REACH]; PARTS];
            for y in 0..REACH {
                let parts = load((top + y) * row + at);
                for part in 0..PARTS {
                    d[part][y] = parts[part];
                }
            }
            for part in 0..PARTS {
                columns[part][column] = tile::inputs(d[part]);
            }
        }
        first = REACH - SIDE;
        for y in 0..REACH {
            let mut rows = [[some; REACH]; PARTS];
            for part in 0..PARTS {
                let mut d = [some; REACH];
                for x in 0..REACH {
                    d[x] = columns[part][x][y];
                }
                rows[part] = tile::inputs(d);
            }
            for x in 0..REACH {
                let mut parts = [some; PARTS];
                for part in 0..PARTS {
                    parts[part] = rows[part][x];
                }
                let place = y * REACH + x;
                store(place, (place * tiles + tile) * pixel + word, parts);
            }
        }
        for part in 0..PARTS {
            columns[part].copy_within(SIDE.., 0);
        }
    }
}

/// The making of AᵀmA of every tile and channel of a block, with bias and activation, in the rows of `out`.
struct TransformBack<'a, T> {
    conv: &'a Winograd,
    block: &'a Block,
    strip: Strip,
    scratch: &'a mut Scratch,
    out: &'a mut [T],
    width: usize,
}

impl<T: Element> VectorWork for TransformBack<'_, T> {
    #[inline(always)]
    fn run<V: Floats>(self, some: V) {
        let Self { conv, block, strip, scratch, out, width } = self;
        let outputs = conv.shape.outputs;
        let channels = block.width.min(outputs - block.first);
        let rows = out.len() / (width * outputs);
        let plane = strip.tiles * block.width;
        let products = &scratch.products[..PLACES * plane];
        let mut pixels = [[0.0; MOST_CHANNELS]; SIDE * SIDE];
        for tile in 0..strip.tiles.min((width - strip.x).div_ceil(SIDE)) {
            for first in (0..block.width).step_by(V::N) {
                let of_tile = &products[tile * block.width + first..];
                let mut columns = [[some; SIDE]; REACH];
                for x in 0..REACH {
                    let mut m = [some; REACH];
                    for y in 0..REACH {
                        let place = y * REACH + x;
                        let sums = &of_tile[place * plane..][..V::N];
                        m[y] = match &block.worth {
                            Some(worth) => {
                                some.load_integers(sums) * some.load(&worth[place * block.width + first..])
                            }
                            None => some.load(cast_slice(sums)),
                        };
                    }
                    columns[x] = tile::outputs(m);
                }
                for y in 0..SIDE {
                    let mut m = [some; REACH];
                    for x in 0..REACH {
                        m[x] = columns[x][y];
                    }
                    let made = tile::outputs(m);
                    for x in 0..SIDE {
                        let pixel = y * SIDE + x;
                        let bias = some.load(&block.bias[pixel * block.width + first..]);
                        (made[x] + bias).store(&mut pixels[pixel][first..]);
                    }
                }
            }
            let x = strip.x + SIDE * tile;
            let columns = SIDE.min(width - x);
            for (y, pixels) in pixels.chunks_exact(SIDE).take(rows).enumerate() {
                let to = &mut out[(y * width + x) * outputs + block.first..];
                for (from, to) in pixels[..columns].iter().zip(to.chunks_mut(outputs)) {
                    finish(&from[..channels], None, conv.shape.activation, &mut to[..channels]);
                }
            }
        }
    }
}

/// Channels of the widest blocks.
const MOST_CHANNELS: usize = 32;
