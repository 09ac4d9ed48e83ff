//! Samples of earlier frames as points, each with its place in its pixel.
//!
//! In a row of points each of their numbers has its own stretch: the colours of all pixels, their weights, and where they
//! lie. So neighbouring pixels are neighbouring numbers of vectors.

use super::floats::{Floats, MOST, VectorWork};
use super::map::Map;
use super::pyramid::{Known, KnownRows};
use super::simd::{Simd, Work};
use crate::plan::POINT;
use glam::{Mat4, Vec4};
use rayon::prelude::*;
use std::array::from_fn;

/// What is known of a pixel of earlier frames, and how far right of and below its centre.
type Point = [f32; POINT];

/// Nothing.
const NONE: Point = [0.0; POINT];

/// The numbers of the points of a row.
#[derive(Debug, Clone, Copy)]
pub struct Row<'a>([&'a [f32]; POINT]);

/// The same, to be written.
#[derive(Debug)]
pub struct RowMut<'a>([&'a mut [f32]; POINT]);

impl<'a> Row<'a> {
    /// Row `y` of `map`.
    #[inline(always)]
    pub fn of(map: &'a Map, y: usize) -> Self {
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

    /// Number `n` of all points.
    #[inline(always)]
    pub fn numbers(&self, n: usize) -> &'a [f32] {
        self.0[n]
    }

    /// The point of pixel `x`.
    #[inline(always)]
    fn point(&self, x: usize) -> Point {
        let [r, g, b, w, right, down] = self.0;
        [r[x], g[x], b[x], w[x], right[x], down[x]]
    }

    /// The numbers of `count` points from pixel `x` on.
    ///
    /// Without closures, here and in what else is done for every pixel: they are functions of their own, compiled for every
    /// processor, if the compiler happens not to put them where they are called.
    #[inline(always)]
    fn window(&self, x: usize, count: usize) -> Self {
        let [r, g, b, w, right, down] = self.0;
        let end = x + count;
        Self([&r[x..end], &g[x..end], &b[x..end], &w[x..end], &right[x..end], &down[x..end]])
    }

    /// Number `n` from pixel `x` on, as vectors like `some`.
    #[inline(always)]
    fn load<V: Floats>(&self, some: V, n: usize, x: usize) -> V {
        some.load(&self.0[n][x..])
    }
}

impl<'a> RowMut<'a> {
    /// Those of a `row` of a map.
    #[inline(always)]
    pub fn of(row: &'a mut [f32]) -> Self {
        let mut stretches = row.chunks_exact_mut(row.len() / POINT);
        Self(from_fn(|_| stretches.next().unwrap_or_default()))
    }

    /// Number `n` of all points.
    #[inline(always)]
    pub fn numbers(&mut self, n: usize) -> &mut [f32] {
        self.0[n]
    }

    /// Makes `point` that of pixel `x`.
    #[inline(always)]
    pub fn set(&mut self, x: usize, point: Point) {
        self.0.iter_mut().zip(point).for_each(|(numbers, number)| numbers[x] = number);
    }

    /// Makes `vector` number `n` of the points from pixel `x` on.
    #[inline(always)]
    fn store<V: Floats>(&mut self, n: usize, x: usize, vector: V) {
        vector.store(&mut self.0[n][x..]);
    }
}

/// Writes to `out` the points of `input` where `motion`, in pixels to the previous position, takes them (see
/// [`Layer::Reproject`](crate::plan::Layer::Reproject)).
pub fn reproject(input: &Map, motion: &Map, out: &mut Map) {
    let [height, width] = [input.height, input.width];
    out.resize([height, width, POINT]);
    out.data.par_chunks_mut(width * POINT).enumerate().for_each(|(y, to)| {
        let motion = motion.row(y).as_chunks().0;
        Simd::best().in_vectors(ReprojectRow { input, motion, y, to: RowMut::of(to) });
    });
}

struct ReprojectRow<'a> {
    input: &'a Map,
    motion: &'a [[f32; 2]],
    y: usize,
    to: RowMut<'a>,
}

impl VectorWork for ReprojectRow<'_> {
    #[inline(always)]
    fn run<V: Floats>(mut self, some: V) {
        let width = self.motion.len();
        let mut first = 0;
        while first < width {
            let end = (first + V::N).min(width);
            match self.corner(first, V::N) {
                Some(corner) => self.vector(first, corner, some),
                None => self.fours(first, end),
            }
            first = end;
        }
    }
}

impl ReprojectRow<'_> {
    /// Makes the pixels from `first` on up to `end`, as many at a time as go together.
    fn fours(&mut self, first: usize, end: usize) {
        for x in (first..end).step_by(Vec4::N) {
            match self.corner(x, Vec4::N).filter(|_| x + Vec4::N <= end) {
                Some(corner) => self.vector(x, corner, Vec4::ZERO),
                None => (x..(x + Vec4::N).min(end)).for_each(|x| self.pixel(x)),
            }
        }
    }

    /// The row and the column that `count` pixels from `first` on take points from, one after the other, if all of them have
    /// moved as many whole pixels, and they and the pixels beside and below them are inside.
    #[inline(always)]
    fn corner(&self, first: usize, count: usize) -> Option<[usize; 2]> {
        let motion = self.motion.get(first..first + count)?;
        let [right, down] = [motion[0][0].floor(), motion[0][1].floor()];
        let mut is_alike = true;
        for moved in motion {
            let [x, y] = [moved[0] - right, moved[1] - down];
            is_alike &= (0.0..1.0).contains(&x) & (0.0..1.0).contains(&y);
        }
        let [left, above] = [first as f32 + right, self.y as f32 + down];
        let is_inside = left >= 0.0
            && left + (count as f32) < self.input.width as f32
            && above >= 0.0
            && above + 1.0 < self.input.height as f32;
        (is_alike && is_inside).then_some([above as usize, left as usize])
    }

    /// Makes the pixels of the vector from `first` on of the points from `corner` on.
    #[inline(always)]
    fn vector<V: Floats>(&mut self, first: usize, [above, left]: [usize; 2], some: V) {
        let [whole_right, whole_down] = [left as f32 - first as f32, above as f32 - self.y as f32];
        let mut parts = [[0.0; MOST]; 2];
        for (i, moved) in self.motion[first..first + V::N].iter().enumerate() {
            parts[0][i] = moved[0] - whole_right;
            parts[1][i] = moved[1] - whole_down;
        }
        let part = [some.load(&parts[0]), some.load(&parts[1])];
        let [zero, low, high] = [some.splat(0.0), some.splat(-0.5), some.splat(0.5)];
        let (mut colours, mut places, mut largest) = ([zero; 4], [zero; 2], zero);
        for down in 0..2 {
            let points = Row::of(self.input, above + down).window(left, V::N + 1);
            for right in 0..2 {
                let x = points.load(some, 4, right) + (some.splat(right as f32) - part[0]);
                let y = points.load(some, 5, right) + (some.splat(down as f32) - part[1]);
                let across = some.both(x.is_at_least(low), x.is_below(high));
                let along = some.both(y.is_at_least(low), y.is_below(high));
                let is_met = some.both(across, along);
                let weight = points.load(some, 3, right).keep(is_met);
                for n in 0..3 {
                    colours[n] = colours[n] + points.load(some, n, right).keep(is_met);
                }
                colours[3] = colours[3] + weight;
                places = [places[0] + weight * x, places[1] + weight * y];
                largest = largest.max(weight);
            }
        }
        let factor = some.splat(1.0) / colours[3].max(some.splat(f32::MIN_POSITIVE));
        let scale = largest * factor;
        for n in 0..4 {
            self.to.store(n, first, colours[n] * scale);
        }
        for n in 0..2 {
            self.to.store(4 + n, first, places[n] * factor);
        }
    }

    /// Makes pixel `x`.
    fn pixel(&mut self, x: usize) {
        let motion = self.motion[x];
        let whole = motion.map(f32::floor);
        let first = [self.y as f32 + whole[1], x as f32 + whole[0]];
        let [height, width] = [self.input.height, self.input.width];
        let is_near = |at: f32, count: usize| at >= -1.0 && at < count as f32;
        // Also where the motion is no number.
        if !(is_near(first[0], height) && is_near(first[1], width)) {
            return self.to.set(x, NONE);
        }
        let part = [motion[0] - whole[0], motion[1] - whole[1]];
        let (mut sums, mut largest) = (NONE, 0.0f32);
        for down in 0..2 {
            let row = first[0] as isize + down;
            if !(0..height as isize).contains(&row) {
                continue;
            }
            let points = Row::of(self.input, row as usize);
            for right in 0..2 {
                let column = first[1] as isize + right;
                if !(0..width as isize).contains(&column) {
                    continue;
                }
                let point = points.point(column as usize);
                let place = [point[4] + (right as f32 - part[0]), point[5] + (down as f32 - part[1])];
                if is_met(place) {
                    for n in 0..4 {
                        sums[n] += point[n];
                    }
                    sums[4] += point[3] * place[0];
                    sums[5] += point[3] * place[1];
                    largest = largest.max(point[3]);
                }
            }
        }
        let factor = 1.0 / sums[3].max(f32::MIN_POSITIVE);
        let scale = largest * factor;
        let [r, g, b, w, right, down] = sums;
        self.to.set(x, [r * scale, g * scale, b * scale, w * scale, right * factor, down * factor]);
    }
}

/// Whether a point so far right of and below the middle of a square of a pixel's size lies in it.
#[inline(always)]
fn is_met(place: [f32; 2]) -> bool {
    place.iter().all(|at| (-0.5..0.5).contains(at))
}

/// Writes to `out` what the points of `input` tell of the centres of pixels (see [`Layer::Splat`](crate::plan::Layer::Splat)).
pub fn splat(input: &Map, out: &mut Map) {
    let [height, width] = [input.height, input.width];
    out.resize([height, width, 4]);
    out.data.par_chunks_mut(width * 4).enumerate().for_each(|(y, to)| {
        let row = |y: usize| (y < height).then(|| Row::of(input, y));
        let rows = [row(y.wrapping_sub(1)), row(y), row(y + 1)];
        Simd::best().in_vectors(SplatRow { rows, to: to.as_chunks_mut().0 });
    });
}

struct SplatRow<'a> {
    /// The row above, if there is one, this one and the one below.
    rows: [Option<Row<'a>>; 3],
    to: &'a mut [Known],
}

impl VectorWork for SplatRow<'_> {
    #[inline(always)]
    fn run<V: Floats>(self, some: V) {
        let Self { rows, to } = self;
        let width = to.len();
        for (number, to) in to.chunks_mut(V::N).enumerate() {
            let first = number * V::N;
            if first > 0 && first + V::N < width {
                splat_vector(&rows, first, to, some);
                continue;
            }
            for (i, to) in to.iter_mut().enumerate() {
                *to = splat_pixel(&rows, first + i, width);
            }
        }
    }
}

/// How far a point tells what is so far left of it (right, if it is negative), in one direction.
#[inline(always)]
fn share(away: f32) -> f32 {
    (1.0 - away.abs()).max(0.0)
}

/// What the points of `rows` tell of the pixels from `first` on.
#[inline(always)]
fn splat_vector<V: Floats>(rows: &[Option<Row<'_>>; 3], first: usize, to: &mut [Known], some: V) {
    let [zero, one] = [some.splat(0.0), some.splat(1.0)];
    let (mut told, mut sum) = ([zero; 4], zero);
    for (below, row) in rows.iter().enumerate() {
        let Some(row) = row else { continue };
        let points = row.window(first - 1, V::N + 2);
        for beside in 0..3 {
            let x = points.load(some, 4, beside) + some.splat(beside as f32 - 1.0);
            let y = points.load(some, 5, beside) + some.splat(below as f32 - 1.0);
            let near = (one - x.abs()).max(zero) * (one - y.abs()).max(zero);
            let weights = points.load(some, 3, beside);
            // Points that are none know nothing, but would have a share.
            let near = near.keep(zero.is_below(weights));
            for n in 0..3 {
                told[n] = told[n] + near * points.load(some, n, beside);
            }
            told[3] = told[3] + near * weights;
            sum = sum + near;
        }
    }
    let factor = one / sum.max(one);
    let mut numbers = [[0.0; MOST]; 4];
    for n in 0..4 {
        (told[n] * factor).store(&mut numbers[n]);
    }
    for (four, to) in to.as_chunks_mut::<4>().0.iter_mut().enumerate() {
        let [r, g, b, w] = [0, 1, 2, 3].map(|n: usize| Vec4::from_slice(&numbers[n][4 * four..]));
        *to = Mat4::from_cols(r, g, b, w).transpose().to_cols_array_2d();
    }
}

/// What they tell of pixel `x` of `width`.
fn splat_pixel(rows: &[Option<Row<'_>>; 3], x: usize, width: usize) -> Known {
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

/// What points know, wherever they are in their pixels.
#[derive(Debug)]
pub struct WithoutPlaces<'a>(pub &'a Map);

impl KnownRows for WithoutPlaces<'_> {
    type Memory = ();

    fn size(&self) -> [usize; 2] {
        [self.0.height, self.0.width]
    }

    fn make(&self, y: usize, (): &mut (), to: &mut Vec<Known>) {
        to.resize(self.0.width, [0.0; 4]);
        Simd::best().vectorised(KnownRow { row: Row::of(self.0, y), to });
    }
}

struct KnownRow<'a> {
    row: Row<'a>,
    to: &'a mut [Known],
}

impl Work for KnownRow<'_> {
    #[inline(always)]
    fn run(self) {
        let Self { row: Row([r, g, b, w, ..]), to } = self;
        let numbers = r.iter().zip(g).zip(b.iter().zip(w));
        to.iter_mut().zip(numbers).for_each(|(to, ((&r, &g), (&b, &w)))| *to = [r, g, b, w]);
    }
}

/// Makes pixel (x, y) of `to`, which keeps its size, pixel (x, y) + `by` of `from`, or the nearest to it.
pub fn shift(from: &Map, by: [i64; 2], to: &mut Map) {
    let nearest = |at: usize, way: i64, count: usize| (at as i64 + way).clamp(0, count as i64 - 1) as usize;
    to.data.par_chunks_mut(to.width * POINT).enumerate().for_each(|(y, row)| {
        let from_row = Row::of(from, nearest(y, by[1], from.height));
        let width = row.len() / POINT;
        let mut row = RowMut::of(row);
        (0..width).for_each(|x| row.set(x, from_row.point(nearest(x, by[0], from.width))));
    });
}

/// The points of `map` pixel by pixel.
pub fn pixels(map: &Map) -> Map {
    let mut out = Map::zeros(map.height, map.width, POINT);
    for (y, row) in out.data.chunks_exact_mut(map.width * POINT).enumerate() {
        let points = Row::of(map, y);
        row.as_chunks_mut().0.iter_mut().enumerate().for_each(|(x, to)| *to = points.point(x));
    }
    out
}

/// The other way round, for tests.
#[cfg(test)]
pub fn of_pixels(map: &Map) -> Map {
    let mut out = Map::zeros(map.height, map.width, POINT);
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

    fn reproject(input: &Map, motion: &Map, out: &mut Map) {
        let mut rows = Map::default();
        super::reproject(&of_pixels(input), motion, &mut rows);
        *out = pixels(&rows);
    }

    fn splat(input: &Map, out: &mut Map) {
        super::splat(&of_pixels(input), out);
    }

    fn row(map: &Map, y: usize) -> &[Point] {
        map.row(y).as_chunks().0
    }

    fn map(channels: usize, pixels: &[([usize; 2], &[f32])]) -> Map {
        let mut map = Map::zeros(SIZE[0], SIZE[1], channels);
        for ([y, x], numbers) in pixels {
            map.data[(y * SIZE[1] + x) * channels..][..channels].copy_from_slice(numbers);
        }
        map
    }

    fn still(motion: [f32; 2]) -> Map {
        let mut map = Map::zeros(SIZE[0], SIZE[1], 2);
        map.data.chunks_exact_mut(2).for_each(|to| to.copy_from_slice(&motion));
        map
    }

    fn moved(input: &Map, motion: [f32; 2]) -> Map {
        let mut out = Map::default();
        reproject(input, &still(motion), &mut out);
        out
    }

    #[test]
    fn points_move_whole_and_keep_their_place() {
        let here = [0.1, 0.2, 0.3, 0.5, 0.25, -0.5];
        let input = map(POINT, &[([2, 3], &here)]);
        assert_eq!(moved(&input, [0.0; 2]).data[..], input.data[..]);
        // Content goes 1.5 to the right and 0.25 up: to 4.75 and 1.25, which is pixel (1, 5).
        let there = moved(&input, [-1.5, 0.25]);
        assert_eq!(there.data[..], map(POINT, &[([1, 5], &[0.1, 0.2, 0.3, 0.5, -0.25, 0.25])]).data[..]);
        // Many small steps lead to where one large one does.
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
        let mut input = Map::zeros(SIZE[0], SIZE[1], POINT);
        input.data.as_chunks_mut::<POINT>().0.fill([0.5, 0.5, 0.5, 1.0, 0.0, 0.0]);
        let left = moved(&input, [-2.0, 0.0]);
        assert!(row(&left, 0)[..2].iter().all(|p| *p == NONE) && row(&left, 0)[2] == row(&input, 0)[2]);
        for motion in [[f32::NAN, 0.0], [f32::INFINITY, 0.0], [0.0, -1e30]] {
            assert!(moved(&input, motion).data.iter().all(|v| *v == 0.0));
        }
    }

    #[test]
    fn points_count_for_the_centres_around_them() {
        let mut out = Map::default();
        splat(&map(POINT, &[([2, 0], &[0.4, 0.4, 0.4, 0.8, -0.25, 0.5])]), &mut out);
        // A quarter of its share falls beyond the border.
        for (at, share) in [([2, 0], 0.375), ([3, 0], 0.375), ([2, 1], 0.0), ([1, 0], 0.0)] {
            assert!((out.pixel(at[0], at[1])[3] - 0.8 * share).abs() < 1e-6, "{at:?}");
        }
        // Where there are more than enough their mean counts.
        let mut input = Map::zeros(SIZE[0], SIZE[1], POINT);
        input.data.as_chunks_mut::<POINT>().0.fill([0.25, 0.5, 0.5, 0.5, 0.0, 0.0]);
        input.data[(2 * SIZE[1] + 3) * POINT..][..POINT].copy_from_slice(&[1.0, 1.0, 1.0, 1.0, 0.25, 0.0]);
        splat(&input, &mut out);
        assert_eq!(out.pixel(0, 0), [0.25, 0.5, 0.5, 0.5]);
        let wanted = (0.25 + 0.25) / 1.25;
        assert!((out.pixel(2, 4)[0] - wanted).abs() < 1e-6, "{:?}", out.pixel(2, 4));
    }
}
