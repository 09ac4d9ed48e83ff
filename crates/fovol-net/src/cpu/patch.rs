//! Pieces of concatenated, resized and padded inputs, as convolutions read them: nothing of the kind is ever
//! written for a whole frame.

use super::map::Map;
use crate::plan::{Padding, Resize};

/// One of the inputs of a layer.
#[derive(Debug, Clone, Copy)]
pub struct Source<'a> {
    /// The tensor.
    pub map: &'a Map,
    /// At which resolution it is read.
    pub resize: Resize,
}

impl Source<'_> {
    /// Rows and columns as they are read.
    pub fn size(&self) -> [usize; 2] {
        let factor = if self.resize == Resize::Same { 1 } else { 2 };
        [self.map.height * factor, self.map.width * factor]
    }

    /// Writes the pixels `x0`…`x0 + count` of row `y`, which are all inside, to every `stride`-th number of `out`.
    fn copy(
        &self,
        y: usize,
        x0: usize,
        count: usize,
        out: &mut [f32],
        stride: usize,
        blended: &mut Vec<f32>,
    ) {
        let c = self.map.channels;
        match self.resize {
            Resize::Same => {
                let from = &self.map.row(y)[x0 * c..(x0 + count) * c];
                if stride == c {
                    out[..count * c].copy_from_slice(from);
                } else {
                    for (to, from) in out.chunks_mut(stride).zip(from.chunks_exact(c)) {
                        to[..c].copy_from_slice(from);
                    }
                }
            }
            Resize::Nearest => {
                for i in 0..count {
                    out[i * stride..][..c].copy_from_slice(self.map.pixel(y / 2, (x0 + i) / 2));
                }
            }
            Resize::Bilinear => {
                let [(a, wa), (b, wb)] = halves(y, self.map.height);
                let first = halves(x0, self.map.width).map(|(at, _)| at).into_iter().min().unwrap_or(0);
                let last = (x0 + count).div_ceil(2).min(self.map.width - 1);
                let columns = first * c..(last + 1) * c;
                // Down first: whole rows at once. Then along them.
                let (above, below) = (&self.map.row(a)[columns.clone()], &self.map.row(b)[columns]);
                blended.clear();
                blended.extend(above.iter().zip(below).map(|(&a, &b)| wa * a + wb * b));
                for i in 0..count {
                    let [(l, wl), (r, wr)] = halves(x0 + i, self.map.width);
                    let near = &blended[(l - first) * c..][..c];
                    let far = &blended[(r - first) * c..][..c];
                    let to = &mut out[i * stride..][..c];
                    for k in 0..c {
                        to[k] = wl * near[k] + wr * far[k];
                    }
                }
            }
        }
    }
}

/// The two places of `count` that place `i` at twice the resolution lies between, with their weights: pixel
/// centres, replicated at the border.
#[inline]
fn halves(i: usize, count: usize) -> [(usize, f32); 2] {
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

/// Writes the `window` of `sources`, concatenated along the channels, to `patch`: `channels` numbers per pixel.
pub fn assemble(
    sources: &[Source<'_>],
    padding: Padding,
    window: Window,
    channels: usize,
    patch: &mut Vec<f32>,
) {
    let [height, width] = sources[0].size();
    let mut blended = Vec::new();
    // Whatever lies beyond the border stays zero.
    patch.clear();
    patch.resize(window.rows * window.columns * channels, 0.0);
    for (row, out) in patch.chunks_mut(window.columns * channels).enumerate() {
        let y = window.y + row as isize;
        let y = match padding {
            Padding::Zero if y < 0 || y >= height as isize => continue,
            _ => y.clamp(0, height as isize - 1) as usize,
        };
        let before = (-window.x).clamp(0, window.columns as isize) as usize;
        let first = (window.x + before as isize) as usize;
        let inside = window.columns.saturating_sub(before).min(width.saturating_sub(first));
        let mut channel = 0;
        for source in sources {
            if inside > 0 {
                source.copy(
                    y,
                    first,
                    inside,
                    &mut out[before * channels + channel..],
                    channels,
                    &mut blended,
                );
            }
            channel += source.map.channels;
        }
        if padding == Padding::Replicate && inside > 0 {
            let pixel = |x: usize| x * channels..(x + 1) * channels;
            (0..before).for_each(|x| out.copy_within(pixel(before), x * channels));
            let end = before + inside;
            (end..window.columns).for_each(|x| out.copy_within(pixel(end - 1), x * channels));
        }
    }
}
