//! Filling by averages of ever larger squares, in the form that an ONNX graph can have.

use super::map::Map;
use super::patch::halves;
use super::simd::{Simd, Work};
use rayon::prelude::*;

/// Divisors are at least this.
const SMALLEST: f32 = 1e-8;
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

/// Writes `colour` where `mask` is 1, and elsewhere the mean of the samples around, to `out`.
///
/// Pulling halves the resolution `levels` times, for which sides must be even: premultiplied colours c and weights w
/// are averaged over 2×2 pixels, then w' = min(4w, 1) and c' = c·w'/max(w, 1e-8). Pushing goes back: each finer
/// level gets c' + (1 − w')·(c of the coarser, bilinear), and its weight likewise. At last colours are divided by
/// max(weight, 1e-8).
pub fn pull_push(colour: &Map, mask: &Map, levels: u32, out: &mut Map) {
    let mut known = vec![premultiplied(colour, mask)];
    for _ in 0..levels {
        known.push(pulled(&known[known.len() - 1]));
    }
    while known.len() > 1 {
        if let (Some(coarser), Some(finer)) = (known.pop(), known.last_mut()) {
            push(finer, &coarser);
        }
    }
    out.resize([colour.height, colour.width, 3]);
    let pixels = out.data.par_chunks_exact_mut(3 * colour.width).enumerate();
    pixels.for_each(|(y, row)| {
        for (to, [r, g, b, w]) in row.chunks_exact_mut(3).zip(known[0].row(y)) {
            to.copy_from_slice(&[r, g, b].map(|v| v / w.max(SMALLEST)));
        }
    });
}

fn premultiplied(colour: &Map, mask: &Map) -> Level {
    let mut pixels = vec![[0.0; 4]; colour.height * colour.width];
    pixels.par_chunks_exact_mut(colour.width).enumerate().for_each(|(y, row)| {
        let samples = colour.row(y).chunks_exact(3).zip(mask.row(y));
        for (to, (rgb, &w)) in row.iter_mut().zip(samples) {
            *to = [rgb[0] * w, rgb[1] * w, rgb[2] * w, w];
        }
    });
    Level { pixels, width: colour.width }
}

fn pulled(finer: &Level) -> Level {
    let width = finer.width / 2;
    let mut pixels = vec![[0.0; 4]; width * (finer.height() / 2)];
    pixels.par_chunks_exact_mut(width).enumerate().for_each(|(y, row)| {
        let rows = finer.row(2 * y).chunks_exact(2).zip(finer.row(2 * y + 1).chunks_exact(2));
        for (to, (above, below)) in row.iter_mut().zip(rows) {
            let sum: Known =
                std::array::from_fn(|c| (above[0][c] + above[1][c]) + (below[0][c] + below[1][c]));
            // Of the mean: min(4w, 1) / max(w, 1e-8).
            let weight = sum[3].min(1.0);
            let factor = 0.25 * weight / (0.25 * sum[3]).max(SMALLEST);
            *to = [sum[0] * factor, sum[1] * factor, sum[2] * factor, weight];
        }
    });
    Level { pixels, width }
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
        blended.clear();
        let rows = coarser.row(a).iter().zip(coarser.row(b));
        blended.extend(rows.map(|(a, b)| -> Known { std::array::from_fn(|c| wa * a[c] + wb * b[c]) }));
        for (x, to) in row.iter_mut().enumerate() {
            let [(l, wl), (r, wr)] = halves(x, coarser.width);
            let (left, right, open) = (&blended[l], &blended[r], 1.0 - to[3]);
            *to = std::array::from_fn(|c| to[c] + open * (wl * left[c] + wr * right[c]));
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
