//! Products on their way to outputs: AᵀmA.

use super::super::finish::finish;
use super::tile::{self, PLACES, REACH, SIDE};
use super::{Block, Scratch, Strip, Winograd};
use crate::cpu::element::Element;
use crate::cpu::floats::{Floats, VectorWork};
use bytemuck::cast_slice;

/// The making of AᵀmA of every tile and channel of a block, with bias and activation, in the rows of `out`.
pub struct TransformBack<'a, T> {
    pub conv: &'a Winograd,
    pub block: &'a Block,
    pub strip: Strip,
    pub scratch: &'a mut Scratch,
    pub out: &'a mut [T],
    pub width: usize,
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
        for tile in 0..strip.tiles.min((width - strip.place[1]).div_ceil(SIDE)) {
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
            let x = strip.place[1] + SIDE * tile;
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
