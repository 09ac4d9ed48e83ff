//! Filling by averages of ever larger squares, in the form that an ONNX graph can have.

use super::map::Map;
use super::patch::halves;
use super::simd::{Simd, Work};
use rayon::prelude::*;

/// Divisors are at least this.
const SMALLEST: f32 = 1e-8;
/// A mean weight of one part in this many is enough to know a pixel of half the resolution.
const GAIN: f32 = 8.0;
/// Rows of a task.
const BAND: usize = 8;

/// Premultiplied red, green and blue, and how far the pixel is known, 0…1.
type Known = [f32; 4];

/// An image of them.
struct Level {
    pixels: Vec<Known>,
    width: usize,
}

impl Level {
    fn row(&self, y: usize) -> &[Known] {
        &self.pixels[y * self.width..(y + 1) * self.width]
    }

    fn height(&self) -> usize {
        self.pixels.len() / self.width
    }
}

/// Spreads `colour`, which is multiplied by `weight`, over `out`: as it is where that is 1, and elsewhere mixed with what
/// is around.
///
/// Pulling halves the resolution `levels` times, for which sides must be even: premultiplied colours c and weights w
/// are averaged over 4×4 pixels by (1, 3, 3, 1)/8 along both axes, replicated at the border, then w' = min(8w, 1) and
/// c' = c·w'/max(w, 1e-8). Pushing goes back: each finer
/// level gets c' + (1 − w')·(c of the coarser, bilinear), and its weight likewise. At last colours are divided by
/// max(weight, 1e-8).
pub fn pull_push(colour: &Map, weight: &Map, levels: u32, out: &mut Map) {
    let mut known: Vec<Level> = Vec::new();
    for _ in 0..levels {
        let next = known.last().map_or_else(|| first_pulled(colour, weight), pulled);
        known.push(next);
    }
    while known.len() > 1 {
        if let (Some(coarser), Some(finer)) = (known.pop(), known.last_mut()) {
            push(finer, &coarser);
        }
    }
    out.resize([colour.height, colour.width, 3]);
    let bands = out.data.par_chunks_mut(3 * BAND * colour.width).enumerate();
    bands.for_each_init(Rows::default, |memory, (band, rows)| {
        for (row, to) in rows.chunks_exact_mut(3 * colour.width).enumerate() {
            let y = band * BAND + row;
            join(colour.row(y), weight.row(y), &mut memory.joined[0]);
            let [row, ..] = &mut memory.joined;
            if let Some(coarser) = known.first() {
                Simd::best().vectorised(PushRow { y, row, coarser, blended: &mut memory.blended });
            }
            divide(row, to);
        }
    });
}

/// Rows that a thread works on.
#[derive(Default)]
struct Rows {
    joined: [Vec<Known>; 4],
    blended: Vec<Known>,
}

/// A row of premultiplied colours with their weights.
fn join(colour: &[f32], weight: &[f32], out: &mut Vec<Known>) {
    let pixels = colour.as_chunks::<3>().0.iter().zip(weight);
    out.clear();
    out.extend(pixels.map(|(&[r, g, b], &w)| [r, g, b, w]));
}

/// The colours of `row`.
fn divide(row: &[Known], to: &mut [f32]) {
    for (to, &[r, g, b, w]) in to.as_chunks_mut::<3>().0.iter_mut().zip(row) {
        let factor = 1.0 / w.max(SMALLEST);
        *to = [r * factor, g * factor, b * factor];
    }
}

/// The first level below the picture itself, which is nowhere as a whole.
fn first_pulled(colour: &Map, weight: &Map) -> Level {
    let width = colour.width / 2;
    let mut pixels = vec![[0.0; 4]; width * (colour.height / 2)];
    let bands = pixels.par_chunks_mut(BAND * width).enumerate();
    bands.for_each_init(Rows::default, |memory, (band, rows)| {
        for (row, to) in rows.chunks_exact_mut(width).enumerate() {
            let rows = around(band * BAND + row, colour.height);
            for (y, joined) in rows.into_iter().zip(&mut memory.joined) {
                join(colour.row(y), weight.row(y), joined);
            }
            let rows = memory.joined.each_ref().map(|row| &row[..]);
            Simd::best().vectorised(PullRow { rows, blended: &mut memory.blended, to });
        }
    });
    Level { pixels, width }
}

fn pulled(finer: &Level) -> Level {
    let width = finer.width / 2;
    let mut pixels = vec![[0.0; 4]; width * (finer.height() / 2)];
    pixels.par_chunks_exact_mut(width).enumerate().for_each_init(Vec::new, |blended, (y, to)| {
        let rows = around(y, finer.height()).map(|y| finer.row(y));
        Simd::best().vectorised(PullRow { rows, blended, to });
    });
    Level { pixels, width }
}

/// The rows of `height` that row `y` of half the resolution is made of.
fn around(y: usize, height: usize) -> [usize; 4] {
    [(2 * y).saturating_sub(1), 2 * y, 2 * y + 1, (2 * y + 2).min(height - 1)]
}

/// The weights of four neighbours.
const BINOMIAL: [f32; 4] = [0.125, 0.375, 0.375, 0.125];

/// The pulling of four rows to one.
struct PullRow<'a> {
    rows: [&'a [Known]; 4],
    blended: &'a mut Vec<Known>,
    to: &'a mut [Known],
}

impl Work for PullRow<'_> {
    #[inline(always)]
    fn run(self) {
        let Self { rows: [a, b, c, d], blended, to } = self;
        let width = a.len();
        // One more on both sides.
        blended.resize(width + 2, [0.0; 4]);
        for (x, blended) in blended[1..=width].iter_mut().enumerate() {
            for k in 0..4 {
                blended[k] = (BINOMIAL[0] * a[x][k] + BINOMIAL[1] * b[x][k])
                    + (BINOMIAL[2] * c[x][k] + BINOMIAL[3] * d[x][k]);
            }
        }
        (blended[0], blended[width + 1]) = (blended[1], blended[width]);
        for (x, to) in to.iter_mut().enumerate() {
            let Some([a, b, c, d]) = blended[2 * x..].first_chunk() else { return };
            let mut mean = [0.0f32; 4];
            for k in 0..4 {
                mean[k] =
                    (BINOMIAL[0] * a[k] + BINOMIAL[1] * b[k]) + (BINOMIAL[2] * c[k] + BINOMIAL[3] * d[k]);
            }
            let weight = (GAIN * mean[3]).min(1.0);
            let factor = weight / mean[3].max(SMALLEST);
            for k in 0..4 {
                to[k] = mean[k] * factor;
            }
            to[3] = weight;
        }
    }
}

/// Adds what is missing in `finer` from `coarser`.
fn push(finer: &mut Level, coarser: &Level) {
    let width = finer.width;
    let bands = finer.pixels.par_chunks_mut(BAND * width).enumerate();
    bands.for_each_init(Vec::new, |blended, (band, rows)| {
        for (y, row) in rows.chunks_exact_mut(width).enumerate() {
            Simd::best().vectorised(PushRow { y: band * BAND + y, row, coarser, blended });
        }
    });
}

/// The pushing of one row.
struct PushRow<'a> {
    y: usize,
    row: &'a mut [Known],
    coarser: &'a Level,
    blended: &'a mut Vec<Known>,
}

impl Work for PushRow<'_> {
    #[inline(always)]
    fn run(self) {
        let Self { y, row, coarser, blended } = self;
        let [(a, wa), (b, wb)] = halves(y, coarser.height());
        let width = coarser.width;
        // One more on both sides, so that every pixel has two neighbours.
        blended.resize(width + 2, [0.0; 4]);
        for (to, (a, b)) in blended[1..].iter_mut().zip(coarser.row(a).iter().zip(coarser.row(b))) {
            for c in 0..4 {
                to[c] = wa * a[c] + wb * b[c];
            }
        }
        (blended[0], blended[width + 1]) = (blended[1], blended[width]);
        for (to, around) in row.as_chunks_mut::<2>().0.iter_mut().zip(blended.windows(3)) {
            let open = [1.0 - to[0][3], 1.0 - to[1][3]];
            for c in 0..4 {
                let near = 0.75 * around[1][c];
                to[0][c] += open[0] * (near + 0.25 * around[0][c]);
                to[1][c] += open[1] * (near + 0.25 * around[2][c]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_stay_and_one_fills_all() {
        let (mut colour, mut mask, mut out) = (Map::zeros(16, 32, 3), Map::zeros(16, 32, 1), Map::default());
        pull_push(&colour, &mask, 4, &mut out);
        assert!(out.data.iter().all(|&v| v == 0.0));
        mask.data[5 * 32 + 7] = 1.0;
        colour.data[3 * (5 * 32 + 7)..][..3].copy_from_slice(&[0.25, 0.5, 1.0]);
        pull_push(&colour, &mask, 4, &mut out);
        assert_eq!(out.pixel(5, 7), [0.25, 0.5, 1.0]);
        let near = out.pixel(6, 9);
        assert!((near[0] - 0.25).abs() < 1e-5 && (near[2] - 1.0).abs() < 1e-5, "{near:?}");
    }
}
