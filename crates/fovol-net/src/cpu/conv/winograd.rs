//! 3×3 convolutions with 16 instead of 36 products for 2×2 outputs: F(2×2, 3×3) of Lavin and Gray, "Fast Algorithms
//! for Convolutional Neural Networks" (2016), after Winograd.
//!
//! Every 4×4 of inputs is transformed to BᵀdB, multiplied with the transformed weights GgGᵀ and summed over the input
//! channels, which is a matrix product for each of the 16 places, and transformed back to 2×2 outputs by AᵀmA.

use super::finish::finish;
use super::{Arithmetic, Call, ConvShape, Kernel, check};
use crate::cpu::element::Element;
use crate::cpu::pack::Singles;
use crate::cpu::patch::{Memory, Source, Window};
use crate::cpu::simd::{Simd, Work};

/// Numbers that are transformed at once; channels are padded to whole ones of them.
const LANES: usize = 16;
type Lane = [f32; LANES];

/// Places of a transformed tile.
const PLACES: usize = 16;

/// About as many bytes may the transformed inputs have: what stays in a second-level cache beside weights.
const TRANSFORMED_BYTES: usize = 384 << 10;

/// Fewer input channels than this do not pay for the transformations.
const FEWEST_INPUTS: usize = 16;

/// A prepared convolution.
#[derive(Debug, Clone)]
pub struct Winograd {
    blocks: Vec<Block>,
    shape: ConvShape,
    /// Input channels, padded.
    channels: usize,
    simd: Simd,
}

/// Some of the output channels.
#[derive(Debug, Clone)]
struct Block {
    first: usize,
    width: usize,
    /// \[place\]\[input channel\]\[channel of the block\].
    weights: Vec<u32>,
    bias: Vec<f32>,
    kernel: Kernel,
}

/// Memory of one thread.
#[derive(Debug, Default)]
pub struct Scratch {
    patch: Vec<f32>,
    memory: Memory,
    /// \[place\]\[tile\]\[input channel\].
    transformed: Vec<f32>,
    /// \[place\]\[tile\]\[channel of the block\].
    products: Vec<f32>,
    row: Vec<f32>,
}

/// Some outputs: rows `y` and `y` + 1, from column `x` on.
#[derive(Clone, Copy)]
struct Strip {
    y: usize,
    x: usize,
    /// Tiles of two columns, whole groups of them.
    tiles: usize,
}

impl Winograd {
    /// Whether `shape` is one that this is for.
    pub fn suits(shape: &ConvShape) -> bool {
        shape.size == 3 && shape.stride == 1 && shape.inputs >= FEWEST_INPUTS
    }

    /// A convolution of `shape` with `weights` \[out, in, 3, 3\] and `bias` \[out\].
    pub fn new(shape: &ConvShape, weights: &[f32], bias: &[f32], simd: Simd) -> Self {
        let channels = shape.inputs.next_multiple_of(LANES);
        let mut blocks = Vec::new();
        let mut first = 0;
        while first < shape.outputs {
            let (width, kernel) = simd.block(shape.outputs - first, &Arithmetic::F32);
            let mut packed = vec![0u32; PLACES * channels * width];
            for output in first..(first + width).min(shape.outputs) {
                for input in 0..shape.inputs {
                    let kernel = &weights[(output * shape.inputs + input) * 9..][..9];
                    for (place, value) in transformed_weights(kernel).into_iter().enumerate() {
                        let at = (place * channels + input) * width + output - first;
                        packed[at] = value.to_bits();
                    }
                }
            }
            let bias = (first..first + width).map(|c| bias.get(c).copied().unwrap_or(0.0)).collect();
            blocks.push(Block { first, width, weights: packed, bias, kernel });
            first += width;
        }
        Self { blocks, shape: *shape, channels, simd }
    }

    /// Its shape.
    pub fn shape(&self) -> &ConvShape {
        &self.shape
    }

    /// Writes the rows from `y` on to `out`.
    pub fn rows<T: Element>(&self, sources: &[Source<'_>], y: usize, scratch: &mut Scratch, out: &mut [T]) {
        check(&self.shape, sources);
        let width = sources[0].size()[1];
        self.simd.vectorised(Band { conv: self, sources, y, width, scratch, out });
    }

    /// Tiles side by side: whole groups, as many as there is room for.
    fn strip_tiles(&self, width: usize) -> usize {
        let group = self.simd.group(&Arithmetic::F32);
        let most = (TRANSFORMED_BYTES / (PLACES * self.channels * size_of::<f32>() * group)).max(1);
        let groups = width.div_ceil(2).div_ceil(group);
        groups.div_ceil(groups.div_ceil(most)) * group
    }

    /// Makes the rows from `y` on.
    #[inline(always)]
    fn band<T: Element>(
        &self,
        sources: &[Source<'_>],
        [y, width]: [usize; 2],
        scratch: &mut Scratch,
        out: &mut [T],
    ) {
        let tiles = self.strip_tiles(width);
        for (pair, out) in out.chunks_mut(2 * width * self.shape.outputs).enumerate() {
            for x in (0..width).step_by(2 * tiles) {
                let strip = Strip { y: y + 2 * pair, x, tiles };
                self.transform(sources, strip, scratch);
                for block in &self.blocks {
                    self.multiply(block, strip, scratch);
                    self.transform_back(block, strip, scratch, out, width);
                }
            }
        }
    }

    /// BᵀdB of every tile and input channel.
    #[inline(always)]
    fn transform(&self, sources: &[Source<'_>], strip: Strip, scratch: &mut Scratch) {
        let Scratch { patch, memory, transformed, .. } = scratch;
        let window = Window {
            y: strip.y as isize - 1,
            x: strip.x as isize - 1,
            rows: 4,
            columns: 2 * strip.tiles + 2,
        };
        let row = window.columns * self.channels;
        patch.resize(4 * row, 0.0);
        for (number, out) in patch.chunks_exact_mut(row).enumerate() {
            if !window.row(
                sources,
                self.shape.padding,
                number,
                (Singles, &mut *out, self.channels),
                (self.simd, &mut *memory),
            ) {
                out.fill(0.0);
            }
        }
        let plane = strip.tiles * self.channels;
        transformed.resize(PLACES * plane, 0.0);
        for tile in 0..strip.tiles {
            for first in (0..self.channels).step_by(LANES) {
                let mut rows = [[[0.0; LANES]; 4]; 4];
                for c in 0..4 {
                    let at = (2 * tile + c) * self.channels + first;
                    let [i, j, k, l] = [
                        lane(patch, at),
                        lane(patch, row + at),
                        lane(patch, 2 * row + at),
                        lane(patch, 3 * row + at),
                    ];
                    // Bᵀ from the left.
                    (rows[0][c], rows[1][c]) = (minus(i, k), plus(j, k));
                    (rows[2][c], rows[3][c]) = (minus(k, j), minus(j, l));
                }
                for r in 0..4 {
                    // B from the right.
                    let [i, j, k, l] = rows[r];
                    let at = 4 * r * plane + tile * self.channels + first;
                    store(minus(i, k), transformed, at);
                    store(plus(j, k), transformed, at + plane);
                    store(minus(k, j), transformed, at + 2 * plane);
                    store(minus(j, l), transformed, at + 3 * plane);
                }
            }
        }
    }

    /// Sums the products over the input channels: a matrix product for each place.
    #[inline(always)]
    fn multiply(&self, block: &Block, strip: Strip, scratch: &mut Scratch) {
        const NO_BIAS: [f32; 32] = [0.0; 32];
        let group = self.simd.group(&Arithmetic::F32);
        let plane = strip.tiles * self.channels;
        scratch.products.resize(PLACES * strip.tiles * block.width, 0.0);
        for place in 0..PLACES {
            let weights = block.weights[place * self.channels * block.width..].as_ptr();
            for tile in (0..strip.tiles).step_by(group) {
                let call = Call {
                    patch: scratch.transformed[place * plane + tile * self.channels..].as_ptr().cast(),
                    row: 0,
                    pixel: self.channels,
                    rows: 1,
                    run: self.channels,
                    weights,
                    bias: NO_BIAS.as_ptr(),
                };
                let to = (place * strip.tiles + tile) * block.width;
                // SAFETY: strips are whole groups of tiles; kernels are only chosen where the processor has them.
                unsafe { (block.kernel)(&call, scratch.products[to..].as_mut_ptr()) };
            }
        }
    }

    /// AᵀmA of every tile and channel of the block, with bias and activation, to the one or two rows of `out`.
    #[inline(always)]
    fn transform_back<T: Element>(
        &self,
        block: &Block,
        strip: Strip,
        scratch: &mut Scratch,
        out: &mut [T],
        width: usize,
    ) {
        let Scratch { products, row, .. } = scratch;
        let outputs = self.shape.outputs;
        let channels = block.width.min(outputs - block.first);
        let plane = strip.tiles * block.width;
        let rows = out.len() / (width * outputs);
        row.resize(4 * block.width, 0.0);
        for tile in 0..strip.tiles.min((width - strip.x).div_ceil(2)) {
            for first in (0..block.width).step_by(LANES) {
                let mut rows = [[[0.0; LANES]; 4]; 2];
                for c in 0..4 {
                    let at = c * plane + tile * block.width + first;
                    let (i, j) = (lane(products, at), lane(products, at + 4 * plane));
                    let (k, l) = (lane(products, at + 8 * plane), lane(products, at + 12 * plane));
                    rows[0][c] = plus(plus(i, j), k);
                    rows[1][c] = minus(minus(j, k), l);
                }
                let bias = lane(&block.bias, first);
                for r in 0..2 {
                    let [i, j, k, l] = rows[r];
                    let at = 2 * r * block.width + first;
                    store(plus(plus(plus(i, j), k), bias), row, at);
                    store(plus(minus(minus(j, k), l), bias), row, at + block.width);
                }
            }
            for (place, from) in row.chunks_exact(block.width).enumerate() {
                let (y, x) = (place / 2, strip.x + 2 * tile + place % 2);
                if y < rows && x < width {
                    let to = (y * width + x) * outputs + block.first;
                    finish(&from[..channels], None, self.shape.activation, &mut out[to..to + channels]);
                }
            }
        }
    }
}

/// The making of some rows.
struct Band<'a, T> {
    conv: &'a Winograd,
    sources: &'a [Source<'a>],
    y: usize,
    width: usize,
    scratch: &'a mut Scratch,
    out: &'a mut [T],
}

impl<T: Element> Work for Band<'_, T> {
    #[inline(always)]
    fn run(self) {
        self.conv.band(self.sources, [self.y, self.width], self.scratch, self.out);
    }
}

/// GgGᵀ of a 3×3 kernel, row by row.
fn transformed_weights(kernel: &[f32]) -> [f32; PLACES] {
    const G: [[f64; 3]; 4] = [[1.0, 0.0, 0.0], [0.5, 0.5, 0.5], [0.5, -0.5, 0.5], [0.0, 0.0, 1.0]];
    std::array::from_fn(|place| {
        let (rows, columns) = (G[place / 4], G[place % 4]);
        let mut sum = 0.0;
        for (y, row) in rows.iter().enumerate() {
            for (x, column) in columns.iter().enumerate() {
                sum += row * column * f64::from(kernel[3 * y + x]);
            }
        }
        sum as f32
    })
}

// Loops: the standard library's functions over arrays are compiled without the vectors of their callers.

#[inline(always)]
fn lane(from: &[f32], at: usize) -> Lane {
    let mut lane = [0.0; LANES];
    lane.copy_from_slice(&from[at..at + LANES]);
    lane
}

#[inline(always)]
fn store(lane: Lane, to: &mut [f32], at: usize) {
    to[at..at + LANES].copy_from_slice(&lane);
}

#[inline(always)]
fn plus(a: Lane, b: Lane) -> Lane {
    let mut sum = [0.0; LANES];
    for i in 0..LANES {
        sum[i] = a[i] + b[i];
    }
    sum
}

#[inline(always)]
fn minus(a: Lane, b: Lane) -> Lane {
    let mut difference = [0.0; LANES];
    for i in 0..LANES {
        difference[i] = a[i] - b[i];
    }
    difference
}
