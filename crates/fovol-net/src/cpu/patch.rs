//! Pieces of concatenated, resized and padded inputs, as convolutions read them: nothing of the kind is ever
//! written for a whole frame.

use super::element::{Bf16, Element};
use super::map::Stored;
use crate::plan::{Padding, Resize};

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

    /// Writes the `count` pixels from column `x0` of row `y` on, which are all inside, to every `stride`-th number
    /// of `out`.
    #[inline(always)]
    fn copy(
        &self,
        [y, x0]: [usize; 2],
        count: usize,
        (out, stride): (&mut [f32], usize),
        memory: &mut Memory,
    ) {
        let [height, width, c] = self.map.size();
        let Memory { near, far } = memory;
        match self.access {
            Access::Folded => {
                let columns = 2 * x0 * c..2 * (x0 + count) * c;
                let above = self.map.numbers(2 * y, columns.clone(), near);
                let below = self.map.numbers(2 * y + 1, columns, far);
                match c {
                    1 => fold::<1>(above, below, out, stride),
                    3 => fold::<3>(above, below, out, stride),
                    4 => fold::<4>(above, below, out, stride),
                    _ => fold_any(c, above, below, out, stride),
                }
            }
            Access::Resized(Resize::Same) => {
                let from = self.map.numbers(y, x0 * c..(x0 + count) * c, near);
                if stride == c {
                    out[..count * c].copy_from_slice(from);
                } else {
                    for (to, from) in out.chunks_mut(stride).zip(from.chunks_exact(c)) {
                        to[..c].copy_from_slice(from);
                    }
                }
            }
            Access::Resized(Resize::Nearest) => {
                let first = x0 / 2;
                let from = self.map.numbers(y / 2, first * c..(x0 + count).div_ceil(2) * c, near);
                for i in 0..count {
                    out[i * stride..][..c].copy_from_slice(&from[((x0 + i) / 2 - first) * c..][..c]);
                }
            }
            Access::Resized(Resize::Bilinear) => {
                let [(a, wa), (b, wb)] = halves(y, height);
                let first = halves(x0, width).map(|(at, _)| at).into_iter().min().unwrap_or(0);
                let last = (x0 + count).div_ceil(2).min(width - 1);
                let columns = first * c..(last + 1) * c;
                // Down first: whole rows at once. Then along them.
                let blended: &mut Vec<f32> = far;
                blended.clear();
                blended.extend(self.map.numbers(a, columns.clone(), near).iter().map(|&v| wa * v));
                let below = self.map.numbers(b, columns, near);
                blended.iter_mut().zip(below).for_each(|(sum, &v)| *sum += wb * v);
                for i in 0..count {
                    let [(l, wl), (r, wr)] = halves(x0 + i, width);
                    let (left, right) = (&blended[(l - first) * c..][..c], &blended[(r - first) * c..][..c]);
                    let to = &mut out[i * stride..][..c];
                    for k in 0..c {
                        to[k] = wl * left[k] + wr * right[k];
                    }
                }
            }
        }
    }
}

/// Writes pixels of C numbers of two rows, 2×2 of them as one, to every `stride`-th number of `out`.
#[inline(always)]
fn fold<const C: usize>(above: &[f32], below: &[f32], out: &mut [f32], stride: usize) {
    let pairs = above.chunks_exact(2 * C).zip(below.chunks_exact(2 * C));
    for (to, (a, b)) in out.chunks_mut(stride).zip(pairs) {
        let to = &mut to[..4 * C];
        for c in 0..C {
            (to[4 * c], to[4 * c + 1], to[4 * c + 2], to[4 * c + 3]) = (a[c], a[C + c], b[c], b[C + c]);
        }
    }
}

/// The same for `c` numbers.
fn fold_any(c: usize, above: &[f32], below: &[f32], out: &mut [f32], stride: usize) {
    let pairs = above.chunks_exact(2 * c).zip(below.chunks_exact(2 * c));
    for (to, (a, b)) in out.chunks_mut(stride).zip(pairs) {
        for (k, to) in to[..4 * c].iter_mut().enumerate() {
            *to = [a, b][k / 2 % 2][k % 2 * c + k / 4];
        }
    }
}

/// Rows on their way.
#[derive(Debug, Default)]
pub struct Memory {
    near: Vec<f32>,
    far: Vec<f32>,
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
    /// Writes row `row` of the window of `sources`, concatenated, to `out`: `channels` numbers per pixel, of which
    /// those that no source has stay as they are. Whether there was anything: beyond a border of zeros there is not.
    #[inline(always)]
    pub fn row(
        &self,
        sources: &[Source<'_>],
        padding: Padding,
        row: usize,
        (out, channels): (&mut [f32], usize),
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
        let mut channel = 0;
        for source in sources {
            let to = &mut out[before * channels + channel..];
            source.copy([y, first], inside, (to, channels), memory);
            channel += source.channels();
        }
        let pixel = |x: usize| x * channels..(x + 1) * channels;
        let end = before + inside;
        if padding == Padding::Replicate {
            (0..before).for_each(|x| out.copy_within(pixel(before), x * channels));
            (end..self.columns).for_each(|x| out.copy_within(pixel(end - 1), x * channels));
        } else {
            out[..before * channels].fill(0.0);
            out[end * channels..].fill(0.0);
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
        if !window.row(sources, padding, row, (out, channels), &mut memory) {
            out.fill(0.0);
        }
    }
}

/// As [`assemble`], in 32-bit words of whatever kernels multiply; pixels begin at whole words.
#[derive(Debug, Default)]
pub struct Patch {
    /// The words.
    pub words: Vec<u32>,
    row: Vec<f32>,
    memory: Memory,
}

/// The numbers that a 32-bit word of a patch holds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Packing<'a> {
    /// One f32.
    F32,
    /// Two bf16.
    Bf16,
    /// Four bytes: value · factor of its channel, rounded, 0…255.
    Bytes(&'a [f32]),
}

impl Packing<'_> {
    /// How many there are.
    pub fn count(self) -> usize {
        match self {
            Self::F32 => 1,
            Self::Bf16 => 2,
            Self::Bytes(_) => 4,
        }
    }
}

impl Patch {
    /// Makes this the `window` of `sources`.
    #[inline(always)]
    pub fn assemble(
        &mut self,
        sources: &[Source<'_>],
        padding: Padding,
        window: Window,
        packing: Packing<'_>,
    ) {
        let inputs: usize = sources.iter().map(|source| source.channels()).sum();
        let words = inputs.div_ceil(packing.count());
        let channels = words * packing.count();
        self.row.clear();
        self.row.resize(window.columns * channels, 0.0);
        self.words.resize(window.rows * window.columns * words, 0);
        for (number, to) in self.words.chunks_exact_mut(window.columns * words).enumerate() {
            let row = (&mut self.row[..], channels);
            if window.row(sources, padding, number, row, &mut self.memory) {
                pack(&self.row, packing, to);
            } else {
                to.fill(0);
            }
        }
    }
}

/// The nearest byte. Next to 2²³ an f32 has no fraction, so its last bits are the whole number: unlike a cast,
/// which minds numbers that are none, this becomes vectors.
#[inline(always)]
fn rounded(value: f32) -> u8 {
    (value.clamp(0.0, 255.0) + 8_388_608.0).to_bits() as u8
}

#[inline(always)]
fn pack(row: &[f32], packing: Packing<'_>, to: &mut [u32]) {
    match packing {
        Packing::F32 => to.iter_mut().zip(row).for_each(|(to, v)| *to = v.to_bits()),
        Packing::Bf16 => {
            let halves: &mut [u16] = bytemuck::cast_slice_mut(to);
            halves.iter_mut().zip(row).for_each(|(to, &v)| *to = Bf16::from_f32(v).0);
        }
        Packing::Bytes(factors) => {
            let bytes: &mut [u8] = bytemuck::cast_slice_mut(to);
            // Factors have a number for every channel of a pixel, whole words of them.
            let pixels = bytes.chunks_exact_mut(factors.len()).zip(row.chunks_exact(factors.len()));
            for (to, row) in pixels {
                for ((to, v), factor) in to.iter_mut().zip(row).zip(factors) {
                    *to = rounded(v * factor);
                }
            }
        }
    }
}
