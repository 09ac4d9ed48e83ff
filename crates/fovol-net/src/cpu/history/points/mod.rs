//! Points: samples of earlier frames, each with its offset within its pixel.
//!
//! A row of points is stored by component: the colours of all pixels, then their weights, then their offsets.
//! Vectors can thus load the components of neighbouring pixels.

mod reproject;
mod splat;

pub use reproject::reproject;
pub use splat::splat;

use crate::cpu::tensor::Tensor;
use crate::plan::POINT;
use fovol_simd::{SimdF32, prefetch};
use rayon::prelude::*;
use std::array::from_fn;

/// Premultiplied colour, weight and offset (right, down) of a point.
type Point = [f32; POINT];

/// An absent point.
const NONE: Point = [0.0; POINT];

/// Components of a row of points.
#[derive(Debug, Clone, Copy)]
pub struct Row<'a>([&'a [f32]; POINT]);

/// Mutable components of a row of points.
#[derive(Debug)]
pub struct RowMut<'a>([&'a mut [f32]; POINT]);

impl<'a> Row<'a> {
    /// Row `y` of `map`.
    #[inline(always)]
    pub fn of(map: &'a Tensor, y: usize) -> Self {
        let (row, w) = (map.row(y), map.width);
        Self([
            &row[..w],
            &row[w..2 * w],
            &row[2 * w..3 * w],
            &row[3 * w..4 * w],
            &row[4 * w..5 * w],
            &row[5 * w..6 * w],
        ])
    }

    /// Point of pixel `x`.
    #[inline(always)]
    fn point(&self, x: usize) -> Point {
        let [r, g, b, w, right, down] = self.0;
        [r[x], g[x], b[x], w[x], right[x], down[x]]
    }

    /// Components of `count` points from pixel `x` on.
    ///
    /// Written without closures, as all code that runs for every pixel: a closure that the compiler does not inline
    /// is compiled for the baseline processor.
    #[inline(always)]
    fn window(&self, x: usize, count: usize) -> Self {
        let [r, g, b, w, right, down] = self.0;
        let end = x + count;
        Self([&r[x..end], &g[x..end], &b[x..end], &w[x..end], &right[x..end], &down[x..end]])
    }

    /// Prefetches the cache lines of the first points of the row below.
    #[inline(always)]
    fn prefetch_below(&self, width: usize) {
        self.0.iter().for_each(|numbers| prefetch(numbers, POINT * width));
    }

    /// Loads component `n` of the points from pixel `x` on.
    #[inline(always)]
    fn load<V: SimdF32>(&self, some: V, n: usize, x: usize) -> V {
        some.load(&self.0[n][x..])
    }
}

impl<'a> RowMut<'a> {
    /// Splits a `row` of a map into components.
    #[inline(always)]
    pub fn of(row: &'a mut [f32]) -> Self {
        let mut stretches = row.chunks_exact_mut(row.len() / POINT);
        Self(from_fn(|_| stretches.next().unwrap_or_default()))
    }

    /// Component `n` of all points.
    #[inline(always)]
    pub fn numbers(&mut self, n: usize) -> &mut [f32] {
        self.0[n]
    }

    /// Sets the point of pixel `x`.
    #[inline(always)]
    pub fn set(&mut self, x: usize, point: Point) {
        self.0.iter_mut().zip(point).for_each(|(numbers, number)| numbers[x] = number);
    }

    /// Stores `vector` in component `n` of the points from pixel `x` on.
    #[inline(always)]
    fn store<V: SimdF32>(&mut self, n: usize, x: usize, vector: V) {
        vector.store(&mut self.0[n][x..]);
    }
}

/// Shifts an image: pixel (x, y) of `to` becomes pixel (x, y) + `by` of `from`, or the nearest one inside. `to`
/// keeps its size.
pub fn shift(from: &Tensor, by: [i64; 2], to: &mut Tensor) {
    let nearest = |at: usize, way: i64, count: usize| (at as i64 + way).clamp(0, count as i64 - 1) as usize;
    to.data.par_chunks_mut(to.width * POINT).enumerate().for_each(|(y, row)| {
        let from_row = Row::of(from, nearest(y, by[1], from.height));
        let width = row.len() / POINT;
        let mut row = RowMut::of(row);
        (0..width).for_each(|x| row.set(x, from_row.point(nearest(x, by[0], from.width))));
    });
}

/// Reorders `map` from components to pixels.
pub fn pixels(map: &Tensor) -> Tensor {
    let mut out = Tensor::zeros(map.height, map.width, POINT);
    for (y, row) in out.data.chunks_exact_mut(map.width * POINT).enumerate() {
        let points = Row::of(map, y);
        row.as_chunks_mut().0.iter_mut().enumerate().for_each(|(x, to)| *to = points.point(x));
    }
    out
}

/// Reorders `map` from pixels to components.
#[cfg(test)]
pub fn of_pixels(map: &Tensor) -> Tensor {
    let mut out = Tensor::zeros(map.height, map.width, POINT);
    for (y, row) in out.data.chunks_exact_mut(map.width * POINT).enumerate() {
        let mut to = RowMut::of(row);
        map.row(y).as_chunks().0.iter().enumerate().for_each(|(x, point)| to.set(x, *point));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: [usize; 2] = [6, 8];

    fn reproject(input: &Tensor, motion: &Tensor, out: &mut Tensor) {
        let mut rows = Tensor::default();
        super::reproject(&of_pixels(input), motion, None, &mut rows);
        *out = pixels(&rows);
    }

    fn splat(input: &Tensor, out: &mut Tensor) {
        super::splat(&of_pixels(input), out);
    }

    fn row(map: &Tensor, y: usize) -> &[Point] {
        map.row(y).as_chunks().0
    }

    fn map(channels: usize, pixels: &[([usize; 2], &[f32])]) -> Tensor {
        let mut map = Tensor::zeros(SIZE[0], SIZE[1], channels);
        for ([y, x], numbers) in pixels {
            map.data[(y * SIZE[1] + x) * channels..][..channels].copy_from_slice(numbers);
        }
        map
    }

    fn still(motion: [f32; 2]) -> Tensor {
        let mut map = Tensor::zeros(SIZE[0], SIZE[1], 2);
        map.data.chunks_exact_mut(2).for_each(|to| to.copy_from_slice(&motion));
        map
    }

    fn moved(input: &Tensor, motion: [f32; 2]) -> Tensor {
        let mut out = Tensor::default();
        reproject(input, &still(motion), &mut out);
        out
    }

    #[test]
    fn points_move_whole_and_keep_their_place() {
        let here = [0.1, 0.2, 0.3, 0.5, 0.25, -0.5];
        let input = map(POINT, &[([2, 3], &here)]);
        assert_eq!(moved(&input, [0.0; 2]).data[..], input.data[..]);
        // The content moves 1.5 pixels right and 0.25 up, to (4.75, 1.25), which lies in pixel (5, 1).
        let there = moved(&input, [-1.5, 0.25]);
        assert_eq!(there.data[..], map(POINT, &[([1, 5], &[0.1, 0.2, 0.3, 0.5, -0.25, 0.25])]).data[..]);
        // Many small steps add up to one large step.
        let mut small = input.clone();
        (0..16).for_each(|_| small = moved(&small, [-0.09375, 0.015625]));
        assert_eq!(small.data[..], there.data[..]);
    }

    #[test]
    fn points_that_meet_become_their_mean() {
        let input = map(
            POINT,
            &[([2, 3], &[0.8, 0.0, 0.0, 0.8, 0.25, 0.0]), ([2, 4], &[0.0, 0.2, 0.0, 0.2, -0.25, 0.0])],
        );
        let met = moved(&input, [0.5, 0.0]);
        let at = row(&met, 2)[3];
        let wanted = [0.64, 0.16, 0.0, 0.8, -0.15, 0.0];
        assert!(at.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-6), "{at:?}");
        assert_eq!(met.data.iter().filter(|v| **v != 0.0).count(), 4);
    }

    #[test]
    fn what_comes_from_outside_or_nowhere_is_nothing() {
        let mut input = Tensor::zeros(SIZE[0], SIZE[1], POINT);
        input.data.as_chunks_mut::<POINT>().0.fill([0.5, 0.5, 0.5, 1.0, 0.0, 0.0]);
        let left = moved(&input, [-2.0, 0.0]);
        assert!(row(&left, 0)[..2].iter().all(|p| *p == NONE) && row(&left, 0)[2] == row(&input, 0)[2]);
        for motion in [[f32::NAN, 0.0], [f32::INFINITY, 0.0], [0.0, -1e30]] {
            assert!(moved(&input, motion).data.iter().all(|v| *v == 0.0));
        }
    }

    #[test]
    fn points_count_for_the_centres_around_them() {
        let mut out = Tensor::default();
        splat(&map(POINT, &[([2, 0], &[0.4, 0.4, 0.4, 0.8, -0.25, 0.5])]), &mut out);
        // A quarter of its weight falls beyond the border.
        for (at, share) in [([2, 0], 0.375), ([3, 0], 0.375), ([2, 1], 0.0), ([1, 0], 0.0)] {
            assert!((out.pixel(at[0], at[1])[3] - 0.8 * share).abs() < 1e-6, "{at:?}");
        }
        // Where the total weight exceeds 1, points are averaged.
        let mut input = Tensor::zeros(SIZE[0], SIZE[1], POINT);
        input.data.as_chunks_mut::<POINT>().0.fill([0.25, 0.5, 0.5, 0.5, 0.0, 0.0]);
        input.data[(2 * SIZE[1] + 3) * POINT..][..POINT].copy_from_slice(&[1.0, 1.0, 1.0, 1.0, 0.25, 0.0]);
        splat(&input, &mut out);
        assert_eq!(out.pixel(0, 0), [0.25, 0.5, 0.5, 0.5]);
        let wanted = (0.25 + 0.25) / 1.25;
        assert!((out.pixel(2, 4)[0] - wanted).abs() < 1e-6, "{:?}", out.pixel(2, 4));
    }
}
