//! Pieces of concatenated, resized and padded inputs, as convolutions read them: nothing of the kind is ever
//! written for a whole frame.

use super::element::Element;
use super::lines::Lines;
use super::map::{Stored, with_map};
use super::pack::{Pack, Singles};
use crate::plan::{Padding, Resize};
use bytemuck::cast_slice_mut;

/// One of the inputs of a layer.
#[derive(Debug, Clone, Copy)]
pub struct Source<'a> {
    /// The tensor.
    pub map: &'a Stored,
    /// How it is read.
    pub access: Access,
}

/// How a tensor is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Access {
    /// At the same or at twice the resolution.
    Resized(Resize),
    /// 2×2 pixels as one with four times the channels: as `reshape::space_to_depth` writes them.
    Folded,
}

impl Access {
    /// As it is.
    pub const SAME: Self = Self::Resized(Resize::Same);
}

impl<'a> Source<'a> {
    /// `map` as `resize` says.
    pub fn new(map: &'a Stored, resize: Resize) -> Self {
        Self { map, access: Access::Resized(resize) }
    }

    /// Rows and columns as they are read.
    pub fn size(&self) -> [usize; 2] {
        let [height, width, _] = self.map.size();
        match self.access {
            Access::Resized(Resize::Same) => [height, width],
            Access::Resized(Resize::Bilinear | Resize::Nearest) => [2 * height, 2 * width],
            Access::Folded => [height / 2, width / 2],
        }
    }

    /// Numbers of a pixel as it is read.
    pub fn channels(&self) -> usize {
        self.map.channels() * if self.access == Access::Folded { 4 } else { 1 }
    }

    /// Writes the `count` pixels from column `x0` of row `y` on, which are all inside, to `out`.
    #[inline(always)]
    fn copy<P: Pack>(
        &self,
        [y, x0]: [usize; 2],
        count: usize,
        out: &mut Pixels<'_, P>,
        Memory { near, far, folded }: &mut Memory,
    ) {
        let [height, width, c] = self.map.size();
        match self.access {
            Access::Folded => {
                let columns = 2 * x0 * c..2 * (x0 + count) * c;
                let above = self.map.numbers(2 * y, columns.clone(), near);
                let below = self.map.numbers(2 * y + 1, columns, far);
                folded.resize(count * 4 * c, 0.0);
                match c {
                    1 => fold::<1>(above, below, folded),
                    3 => fold::<3>(above, below, folded),
                    4 => fold::<4>(above, below, folded),
                    _ => fold_any(c, above, below, folded),
                }
                for (x, pixel) in folded.chunks_exact(4 * c).enumerate() {
                    out.write(x, pixel);
                }
            }
            Access::Resized(Resize::Same) => with_map!(self.map, map => {
                out.write_all(&map.row(y)[x0 * c..(x0 + count) * c], c);
            }),
            Access::Resized(Resize::Nearest) => with_map!(self.map, map => {
                let row = map.row(y / 2);
                for x in 0..count {
                    out.write(x, &row[(x0 + x) / 2 * c..][..c]);
                }
            }),
            Access::Resized(Resize::Bilinear) => {
                let [(a, wa), (b, wb)] = halves(y, height);
                let [(near, _), (beside, _)] = halves(x0, width);
                let first = near.min(beside);
                let last = (x0 + count).div_ceil(2).min(width - 1);
                let columns = first * c..(last + 1) * c;
                // Down first: whole rows at once. Then along them.
                far.resize(columns.len(), 0.0);
                with_map!(self.map, map => {
                    let rows = map.row(a)[columns.clone()].iter().zip(&map.row(b)[columns]);
                    for (to, (a, b)) in far.iter_mut().zip(rows) {
                        *to = wa * a.to_f32() + wb * b.to_f32();
                    }
                });
                for x in 0..count {
                    let [(l, wl), (r, wr)] = halves(x0 + x, width);
                    let (left, right) = (&far[(l - first) * c..][..c], &far[(r - first) * c..][..c]);
                    out.write_sum(x, (left, wl), (right, wr));
                }
            }
        }
    }
}

/// Pixels of a patch, of which a source writes some channels.
struct Pixels<'a, P: Pack> {
    pack: P,
    numbers: &'a mut [P::Number],
    /// From one pixel to the next.
    stride: usize,
    /// The first channel that is written.
    channel: usize,
}

impl<P: Pack> Pixels<'_, P> {
    /// Writes `channels` of a pixel.
    #[inline(always)]
    fn write<T: Element>(&mut self, x: usize, channels: &[T]) {
        let to = &mut self.numbers[x * self.stride + self.channel..][..channels.len()];
        self.pack.numbers(self.channel, channels, to);
    }

    /// Writes pixels from the first on, with `count` channels each.
    #[inline(always)]
    fn write_all<T: Element>(&mut self, pixels: &[T], count: usize) {
        for (x, channels) in pixels.chunks_exact(count).enumerate() {
            self.write(x, channels);
        }
    }

    /// Writes the sum of `left` and `right`, each times its weight.
    #[inline(always)]
    fn write_sum(&mut self, x: usize, left: (&[f32], f32), right: (&[f32], f32)) {
        let to = &mut self.numbers[x * self.stride + self.channel..][..left.0.len()];
        self.pack.sums(self.channel, left, right, to);
    }
}

/// Writes pixels of C numbers of two rows, 2×2 of them as one, to `out`.
#[inline(always)]
fn fold<const C: usize>(above: &[f32], below: &[f32], out: &mut [f32]) {
    let pairs = above.chunks_exact(2 * C).zip(below.chunks_exact(2 * C));
    for (to, (a, b)) in out.chunks_exact_mut(4 * C).zip(pairs) {
        for c in 0..C {
            (to[4 * c], to[4 * c + 1], to[4 * c + 2], to[4 * c + 3]) = (a[c], a[C + c], b[c], b[C + c]);
        }
    }
}

/// The same for `c` numbers.
fn fold_any(c: usize, above: &[f32], below: &[f32], out: &mut [f32]) {
    let pairs = above.chunks_exact(2 * c).zip(below.chunks_exact(2 * c));
    for (to, (a, b)) in out.chunks_exact_mut(4 * c).zip(pairs) {
        for (k, to) in to.iter_mut().enumerate() {
            *to = [a, b][k / 2 % 2][k % 2 * c + k / 4];
        }
    }
}

/// Rows on their way.
#[derive(Debug, Default)]
pub struct Memory {
    near: Vec<f32>,
    far: Vec<f32>,
    folded: Vec<f32>,
}

/// The two places of `count` that place `i` at twice the resolution lies between, with their weights: pixel
/// centres, replicated at the border.
#[inline(always)]
pub fn halves(i: usize, count: usize) -> [(usize, f32); 2] {
    let near = i / 2;
    let far = if i.is_multiple_of(2) { near.saturating_sub(1) } else { (near + 1).min(count - 1) };
    [(near, 0.75), (far, 0.25)]
}

/// The part of the inputs that a patch covers.
#[derive(Debug, Clone, Copy)]
pub struct Window {
    /// The first row, which may lie before the border.
    pub y: isize,
    /// The first column, which may lie before the border.
    pub x: isize,
    /// Rows.
    pub rows: usize,
    /// Columns.
    pub columns: usize,
}

impl Window {
    /// Writes row `row` of the window of `sources`, concatenated, to `out`: `channels` numbers per pixel, zeros where no
    /// source has any. Whether there was anything: beyond a border of zeros there is not.
    #[inline(always)]
    pub fn row<P: Pack>(
        &self,
        sources: &[Source<'_>],
        padding: Padding,
        row: usize,
        (pack, out, channels): (P, &mut [P::Number], usize),
        memory: &mut Memory,
    ) -> bool {
        let [height, width] = sources[0].size();
        let y = self.y + row as isize;
        let y = match padding {
            Padding::Zero if y < 0 || y >= height as isize => return false,
            _ => y.clamp(0, height as isize - 1) as usize,
        };
        let before = (-self.x).clamp(0, self.columns as isize) as usize;
        let first = (self.x + before as isize) as usize;
        let inside = self.columns.saturating_sub(before).min(width.saturating_sub(first));
        if inside == 0 {
            return false;
        }
        let end = before + inside;
        let mut to = Pixels {
            pack,
            numbers: &mut out[before * channels..end * channels],
            stride: channels,
            channel: 0,
        };
        for source in sources {
            source.copy([y, first], inside, &mut to, memory);
            to.channel += source.channels();
        }
        let filled = to.channel;
        if filled < channels {
            for pixel in to.numbers.chunks_exact_mut(channels) {
                pixel[filled..].fill(P::Number::default());
            }
        }
        let pixel = |x: usize| x * channels..(x + 1) * channels;
        if padding == Padding::Replicate {
            (0..before).for_each(|x| out.copy_within(pixel(before), x * channels));
            (end..self.columns).for_each(|x| out.copy_within(pixel(end - 1), x * channels));
        } else {
            out[..before * channels].fill(P::Number::default());
            out[end * channels..].fill(P::Number::default());
        }
        true
    }
}

/// Writes the `window` of `sources`, concatenated along the channels, to `patch`.
#[inline(always)]
pub fn assemble(sources: &[Source<'_>], padding: Padding, window: Window, patch: &mut Vec<f32>) {
    let channels: usize = sources.iter().map(|source| source.channels()).sum();
    let mut memory = Memory::default();
    patch.resize(window.rows * window.columns * channels, 0.0);
    for (row, out) in patch.chunks_mut(window.columns * channels).enumerate() {
        if !window.row(sources, padding, row, (Singles, &mut *out, channels), &mut memory) {
            out.fill(0.0);
        }
    }
}

/// As [`assemble`], in 32-bit words of whatever kernels multiply; pixels begin at whole words, and some zeros follow that
/// kernels may read.
#[derive(Debug, Default)]
pub struct Patch {
    /// The words.
    pub words: Lines,
    memory: Memory,
}

/// Words after the last row.
const BEYOND: usize = 16;

impl Patch {
    /// Makes this the `window` of `sources`.
    #[inline(always)]
    pub fn assemble<P: Pack>(&mut self, sources: &[Source<'_>], padding: Padding, window: Window, pack: P) {
        let inputs: usize = sources.iter().map(|source| source.channels()).sum();
        let per_word = size_of::<u32>() / size_of::<P::Number>();
        let words = inputs.div_ceil(per_word);
        let length = window.rows * window.columns * words;
        self.words.resize(length + BEYOND);
        self.words[length..].fill(0);
        for (number, to) in self.words[..length].chunks_exact_mut(window.columns * words).enumerate() {
            let numbers: &mut [P::Number] = cast_slice_mut(to);
            let row = (pack, numbers, words * per_word);
            if !window.row(sources, padding, number, row, &mut self.memory) {
                to.fill(0);
            }
        }
    }
}
