//! Resamples points at pixel centres.

use super::Row;
use crate::cpu::pyramid::PremulRgba;
use crate::cpu::tensor::Tensor;
use crate::cpu::vec4::four;
use fovol_simd::{MOST_LANES, Pixels, Simd, SimdF32, SimdF32Op};
use glam::Vec4;
use rayon::prelude::*;

/// Resamples the points of `input` at pixel centres and writes weighted pixels to `out`; see
/// [`Splat`](crate::plan::Splat).
pub fn splat(input: &Tensor, out: &mut Tensor) {
    let [height, width] = [input.height, input.width];
    out.resize([height, width, 4]);
    out.data.par_chunks_mut(width * 4).enumerate().for_each(|(y, to)| {
        let row = |y: usize| (y < height).then(|| Row::of(input, y));
        let rows = [row(y.wrapping_sub(1)), row(y), row(y + 1)];
        Simd::best().in_vectors(SplatRow { rows, to: to.as_chunks_mut().0 });
    });
}

struct SplatRow<'a> {
    /// Row above, this row and the row below; `None` beyond the border.
    rows: [Option<Row<'a>>; 3],
    to: &'a mut [PremulRgba],
}

impl SimdF32Op for SplatRow<'_> {
    type Output = ();

    #[inline(always)]
    fn run<V: SimdF32>(self, some: V) {
        let Self { rows, to } = self;
        let width = to.len();
        // Vectors need pixels on both sides. The last vector overlaps the one before.
        let last = (width.saturating_sub(1)).checked_sub(V::N).filter(|last| *last > 0);
        let firsts = last.into_iter().flat_map(|last| (1..last).step_by(V::N).chain([last]));
        for first in firsts {
            splat_vector(&rows, first, width, &mut to[first..first + V::N], some);
        }
        let alone = if last.is_some() { [0..1, width - 1..width] } else { [0..width, 0..0] };
        for x in alone.into_iter().flatten() {
            to[x] = splat_pixel(&rows, x, width);
        }
    }
}

/// Bilinear weight of a point at distance `away` along one axis.
#[inline(always)]
fn share(away: f32) -> f32 {
    (1.0 - away.abs()).max(0.0)
}

/// Resamples the points of `rows` at a vector of pixels from `first` on.
#[inline(always)]
fn splat_vector<V: SimdF32>(
    rows: &[Option<Row<'_>>; 3],
    first: usize,
    width: usize,
    to: &mut [PremulRgba],
    some: V,
) {
    let [zero, one] = [some.splat(0.0), some.splat(1.0)];
    let (mut told, mut sum) = ([zero; 4], zero);
    for (below, row) in rows.iter().enumerate() {
        let Some(row) = row else { continue };
        let points = row.window(first - 1, V::N + 2);
        if below == 2 {
            points.prefetch_below(width);
        }
        for beside in 0..3 {
            let x = points.load(some, 4, beside) + some.splat(beside as f32 - 1.0);
            let y = points.load(some, 5, beside) + some.splat(below as f32 - 1.0);
            let near = (one - x.abs()).max(zero) * (one - y.abs()).max(zero);
            let weights = points.load(some, 3, beside);
            // Absent points have weight 0, but would get a bilinear weight.
            let near = near.zero_unless(zero.simd_lt(weights));
            for n in 0..3 {
                told[n] = told[n] + near * points.load(some, n, beside);
            }
            told[3] = told[3] + near * weights;
            sum = sum + near;
        }
    }
    let factor = sum.max(one).recip();
    let mut numbers = [[0.0; MOST_LANES]; 4];
    for n in 0..4 {
        (told[n] * factor).store(&mut numbers[n]);
    }
    for (number, to) in to.as_chunks_mut::<4>().0.iter_mut().enumerate() {
        let [r, g, b, w] = &numbers;
        let at = 4 * number;
        let pixels = Vec4::pixels_transposed([four(r, at), four(g, at), four(b, at), four(w, at)]);
        for (to, pixel) in to.iter_mut().zip(pixels) {
            *to = pixel.to_array();
        }
    }
}

/// Resamples the points of `rows` at pixel `x` of `width`.
fn splat_pixel(rows: &[Option<Row<'_>>; 3], x: usize, width: usize) -> PremulRgba {
    let (mut told, mut shares) = (Vec4::ZERO, 0.0f32);
    for (below, row) in rows.iter().enumerate() {
        let Some(row) = row else { continue };
        for from in x.saturating_sub(1)..(x + 2).min(width) {
            let point @ [.., right, down] = row.point(from);
            let near = share(right + (from as f32 - x as f32)) * share(down + (below as f32 - 1.0));
            if point[3] > 0.0 {
                told += near * Vec4::from_slice(&point);
                shares += near;
            }
        }
    }
    (told * (1.0 / shares.max(1.0))).to_array()
}
