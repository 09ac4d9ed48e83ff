//! Filling by averages of ever larger squares, in the form that an ONNX graph can have.

use super::map::{Map, Stored};
use super::patch::{Source, Window, assemble};
use super::reshape::pool;
use crate::plan::{Padding, Resize};
use rayon::prelude::*;

/// Divisors are at least this.
const SMALLEST: f32 = 1e-8;
/// Rows of a task.
const BAND: usize = 8;
/// Pixels that are not worth a task of their own.
const FEW: usize = 4096;

/// Premultiplied colours, and how far each pixel is known, 0…1.
struct Known {
    colour: Map,
    weight: Map,
}

/// Writes `colour` where `mask` is 1, and elsewhere the mean of the samples around, to `out`.
///
/// Pulling halves the resolution `levels` times, for which sides must be even: premultiplied colours c and weights w are
/// averaged over 2×2 pixels, then w' = min(4w, 1) and c' = c·w'/max(w, 1e-8). Pushing goes back: each finer level
/// gets c' + (1 − w')·(c of the coarser, bilinear), and its weight likewise. At last colours are divided by
/// max(weight, 1e-8).
pub fn pull_push(colour: &Map, mask: &Map, levels: u32, out: &mut Map) {
    let mut known = vec![premultiplied(colour, mask)];
    for _ in 0..levels {
        known.push(pulled(&known[known.len() - 1]));
    }
    let pushed = known.into_iter().rev().reduce(|coarser, finer| Known {
        colour: pushed(finer.colour, &finer.weight, coarser.colour),
        weight: pushed(finer.weight.clone(), &finer.weight, coarser.weight),
    });
    *out = pushed.map(divided).unwrap_or_default();
}

fn premultiplied(colour: &Map, mask: &Map) -> Known {
    let mut known = Known { colour: colour.clone(), weight: mask.clone() };
    let pixels = known.colour.data.par_chunks_exact_mut(colour.channels).zip(&mask.data);
    pixels.with_min_len(FEW).for_each(|(pixel, &w)| pixel.iter_mut().for_each(|v| *v *= w));
    known
}

fn pulled(finer: &Known) -> Known {
    let mut known = Known { colour: Map::default(), weight: Map::default() };
    pool(&finer.colour, &mut known.colour);
    pool(&finer.weight, &mut known.weight);
    let channels = known.colour.channels;
    let pixels = known.colour.data.par_chunks_exact_mut(channels).zip(&mut known.weight.data);
    pixels.with_min_len(FEW).for_each(|(pixel, w)| {
        let full = (4.0 * *w).min(1.0);
        let factor = full / w.max(SMALLEST);
        pixel.iter_mut().for_each(|v| *v *= factor);
        *w = full;
    });
    known
}

fn divided(known: Known) -> Map {
    let Known { mut colour, weight } = known;
    let pixels = colour.data.par_chunks_exact_mut(colour.channels).zip(&weight.data);
    pixels.with_min_len(FEW).for_each(|(pixel, w)| pixel.iter_mut().for_each(|v| *v /= w.max(SMALLEST)));
    colour
}

/// `finer` + (1 − `weight`) · `coarser`.
fn pushed(finer: Map, weight: &Map, coarser: Map) -> Map {
    let mut out = finer;
    let coarser = Stored::F32(coarser);
    let source = [Source { map: &coarser, resize: Resize::Bilinear }];
    let (width, channels) = (out.width, out.channels);
    out.data.par_chunks_mut(BAND * width * channels).enumerate().for_each_init(
        Vec::new,
        |up, (band, rows)| {
            let y = band * BAND;
            let window =
                Window { y: y as isize, x: 0, rows: rows.len() / (width * channels), columns: width };
            assemble(&source, Padding::Zero, window, up);
            let pixels = rows.chunks_exact_mut(channels).zip(up.chunks_exact(channels));
            for ((pixel, up), &w) in pixels.zip(&weight.data[y * width..]) {
                (0..channels).for_each(|k| pixel[k] += (1.0 - w) * up[k]);
            }
        },
    );
    out
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
