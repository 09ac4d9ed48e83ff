//! Output transform AᵀmA.

use super::super::finish::{LARGEST, elu};
use super::parts::{Block, Scratch, Strip, Winograd};
use super::tile::{self, PLACES, REACH, SIDE};
use crate::cpu::tensor::element::Element;
use crate::plan::Activation;
use bytemuck::cast_slice;
use fovol_simd::{MOST_LANES, SimdF32, SimdF32Op};

/// Operation that computes AᵀmA for every tile and channel of a block, adds bias, applies the activation, and
/// writes rows of `out`.
pub struct TransformBack<'a, T> {
    pub conv: &'a Winograd,
    pub block: &'a Block,
    pub strip: Strip,
    pub scratch: &'a mut Scratch,
    pub out: &'a mut [T],
    pub width: usize,
}

impl<T: Element> SimdF32Op for TransformBack<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run<V: SimdF32>(self, some: V) {
        let Self { conv, block, strip, scratch, out, width } = self;
        let outputs = conv.shape.outputs;
        let channels = block.width.min(outputs - block.first);
        let rows = out.len() / (width * outputs);
        let plane = strip.tiles * block.width;
        let products = &scratch.products[..PLACES * plane];
        let mut last = [T::default(); MOST_LANES];
        for tile in 0..strip.tiles.min((width - strip.place[1]).div_ceil(SIDE)) {
            let x0 = strip.place[1] + SIDE * tile;
            let inside = SIDE.min(width - x0);
            for first in (0..channels).step_by(V::N) {
                let count = V::N.min(channels - first);
                let sums = Sums { products, plane, block, tile, first };
                // Written out, because filling an array with zeros first would double the time.
                let columns = [
                    sums.column(0, some),
                    sums.column(1, some),
                    sums.column(2, some),
                    sums.column(3, some),
                    sums.column(4, some),
                    sums.column(5, some),
                ];
                for y in 0..rows {
                    let mut m = [some; REACH];
                    for x in 0..REACH {
                        m[x] = columns[x][y];
                    }
                    let made = tile::outputs(m);
                    for x in 0..inside {
                        let bias = some.load(&block.bias[(y * SIDE + x) * block.width + first..]);
                        let value = active(made[x] + bias, conv.shape.activation);
                        let to = &mut out[(y * width + x0 + x) * outputs + block.first + first..][..count];
                        if count == V::N {
                            T::store(value, to);
                        } else {
                            T::store(value, &mut last);
                            to.copy_from_slice(&last[..count]);
                        }
                    }
                }
            }
        }
    }
}

/// Products of a tile for some channels of a block.
struct Sums<'a> {
    products: &'a [u32],
    /// Distance between places.
    plane: usize,
    block: &'a Block,
    tile: usize,
    /// First channel.
    first: usize,
}

impl Sums<'_> {
    /// Computes column `x` of Aᵀm.
    #[inline(always)]
    fn column<V: SimdF32>(&self, x: usize, some: V) -> [V; SIDE] {
        let Self { products, plane, block, tile, first } = self;
        let of_tile = &products[tile * block.width + first..];
        let mut m = [some; REACH];
        for y in 0..REACH {
            let place = y * REACH + x;
            let sums = &of_tile[place * plane..][..V::N];
            m[y] = match &block.worth {
                Some(worth) => some.load_integers(sums) * some.load(&worth[place * block.width + first..]),
                None => some.load(cast_slice(sums)),
            };
        }
        tile::outputs(m)
    }
}

/// Applies `activation` to `values`.
#[inline(always)]
fn active<V: SimdF32>(values: V, activation: Activation) -> V {
    match activation {
        Activation::None => values,
        Activation::Relu => {
            let positive = values.max(values.splat(0.0));
            positive.zero_unless(positive.simd_lt(values.splat(LARGEST)))
        }
        Activation::Elu => {
            let mut each = [0.0; MOST_LANES];
            values.store(&mut each);
            each.iter_mut().take(V::N).for_each(|v| *v = elu(*v));
            values.load(&each)
        }
    }
}
