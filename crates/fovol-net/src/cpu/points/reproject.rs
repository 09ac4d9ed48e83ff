//! Reprojects points of the last frame.

use super::{NONE, Row, RowMut};
use crate::cpu::accumulate::Fading;
use crate::cpu::motion::{corner_of, whole_motion};
use crate::cpu::tensor::Tensor;
use crate::plan::POINT;
use fovol_simd::{MOST_LANES, Simd, SimdF32, SimdF32Op};
use rayon::prelude::*;

/// Moves the points of `input` along `motion`, in pixels to the previous position, and writes them to `out`. With
/// `fading` they are accumulated at once. See [`Reproject`](crate::plan::Reproject).
pub fn reproject(input: &Tensor, motion: &Tensor, fading: Option<Fading<'_>>, out: &mut Tensor) {
    let [height, width] = [input.height, input.width];
    out.resize([height, width, POINT]);
    out.data.par_chunks_mut(width * POINT).enumerate().for_each_init(Vec::new, |shares, (y, to)| {
        let motion = motion.row(y).as_chunks().0;
        Simd::best().in_vectors(ReprojectRow { input, motion, y, to: RowMut::of(to) });
        // Accumulated at once, while the row is in the cache.
        if let Some(fading) = fading {
            fading.row(y, POINT, to, shares);
        }
    });
}

struct ReprojectRow<'a> {
    input: &'a Tensor,
    motion: &'a [[f32; 2]],
    y: usize,
    to: RowMut<'a>,
}

impl SimdF32Op for ReprojectRow<'_> {
    type Output = ();

    #[inline(always)]
    fn run<V: SimdF32>(mut self, some: V) {
        let width = self.motion.len();
        let mut first = 0;
        while first < width {
            let end = (first + V::N).min(width);
            match self.corner(first, V::N) {
                Some(corner) => self.vector(first, corner, some),
                None if first + V::N <= width => self.apart(first, some),
                None => (first..end).for_each(|x| self.pixel(x)),
            }
            first = end;
        }
    }
}

/// Largest number of different whole-pixel motions in a vector. Remaining pixels are computed one by one.
const CORNERS: usize = 4;

impl ReprojectRow<'_> {
    /// Returns row and column of the first source of `count` pixels from `first` on, if all have the same
    /// whole-pixel motion and all sources lie inside.
    #[inline(always)]
    fn corner(&self, first: usize, count: usize) -> Option<[usize; 2]> {
        let (whole, is_all) = whole_motion(self.motion.get(first..first + count)?);
        self.inside(whole, first, count).filter(|_| is_all)
    }

    /// Computes a vector of pixels from `first` on that have different motions. Pixels with equal whole-pixel
    /// motion are computed together.
    #[inline(always)]
    fn apart<V: SimdF32>(&mut self, first: usize, some: V) {
        let mut whole = [[0.0; MOST_LANES]; 2];
        for (i, moved) in self.motion[first..first + V::N].iter().enumerate() {
            whole[0][i] = moved[0].floor();
            whole[1][i] = moved[1].floor();
        }
        // One bit for each pixel that is not yet computed, and for each that no vector can compute.
        let (mut open, mut alone) = ((1u32 << V::N) - 1, 0);
        let mut made = [some.splat(0.0); POINT];
        for _ in 0..CORNERS {
            let number = open.trailing_zeros() as usize;
            if number >= V::N {
                break;
            }
            let [right, down] = [whole[0][number], whole[1][number]];
            let mut alike = 0;
            for i in 0..V::N {
                alike |= u32::from(whole[0][i] == right && whole[1][i] == down) << i;
            }
            // NaN is unequal to itself, so this bit is set explicitly.
            alike |= 1 << number;
            open &= !alike;
            let Some(corner) = self.inside([right, down], first, V::N) else {
                alone |= alike;
                continue;
            };
            let values = self.moved(first, corner, some);
            let [x, y] = [some.load(&whole[0]), some.load(&whole[1])];
            let [x_end, y_end] = [some.splat(right + 1.0), some.splat(down + 1.0)];
            let across = x.simd_ge(some.splat(right)) & x.simd_lt(x_end);
            let along = y.simd_ge(some.splat(down)) & y.simd_lt(y_end);
            let is_alike = across & along;
            for n in 0..POINT {
                made[n] = made[n] + values[n].zero_unless(is_alike);
            }
        }
        for n in 0..POINT {
            self.to.store(n, first, made[n]);
        }
        for i in 0..V::N {
            if (open | alone) >> i & 1 == 1 {
                self.pixel(first + i);
            }
        }
    }

    /// Returns row and column of the first source of `count` pixels from `first` on for the motion `whole`, if all
    /// sources lie inside.
    #[inline(always)]
    fn inside(&self, whole: [f32; 2], first: usize, count: usize) -> Option<[usize; 2]> {
        corner_of(count, [self.y, first], whole, [self.input.height, self.input.width])
    }

    /// Computes a vector of pixels from `first` on, whose sources begin at `corner`.
    #[inline(always)]
    fn vector<V: SimdF32>(&mut self, first: usize, corner: [usize; 2], some: V) {
        let values = self.moved(first, corner, some);
        for n in 0..POINT {
            self.to.store(n, first, values[n]);
        }
    }

    /// Returns a vector of points for the pixels from `first` on, whose sources begin at row `above` and column
    /// `left`.
    #[inline(always)]
    fn moved<V: SimdF32>(&self, first: usize, [above, left]: [usize; 2], some: V) -> [V; POINT] {
        let [whole_right, whole_down] = [left as f32 - first as f32, above as f32 - self.y as f32];
        let mut parts = [[0.0; MOST_LANES]; 2];
        for (i, moved) in self.motion[first..first + V::N].iter().enumerate() {
            parts[0][i] = moved[0] - whole_right;
            parts[1][i] = moved[1] - whole_down;
        }
        let part = [some.load(&parts[0]), some.load(&parts[1])];
        let [zero, low, high] = [some.splat(0.0), some.splat(-0.5), some.splat(0.5)];
        let (mut colours, mut places, mut largest) = ([zero; 4], [zero; 2], zero);
        for down in 0..2 {
            let points = Row::of(self.input, above + down).window(left, V::N + 1);
            if down == 1 {
                points.prefetch_below(self.input.width);
            }
            for right in 0..2 {
                let x = points.load(some, 4, right) + (some.splat(right as f32) - part[0]);
                let y = points.load(some, 5, right) + (some.splat(down as f32) - part[1]);
                let across = x.simd_ge(low) & x.simd_lt(high);
                let along = y.simd_ge(low) & y.simd_lt(high);
                let is_met = across & along;
                let weight = points.load(some, 3, right).zero_unless(is_met);
                for n in 0..3 {
                    colours[n] = colours[n] + points.load(some, n, right).zero_unless(is_met);
                }
                colours[3] = colours[3] + weight;
                places = [places[0] + weight * x, places[1] + weight * y];
                largest = largest.max(weight);
            }
        }
        let factor = colours[3].max(some.splat(f32::MIN_POSITIVE)).recip();
        let scale = largest * factor;
        let [r, g, b, weight] = colours;
        [r * scale, g * scale, b * scale, weight * scale, places[0] * factor, places[1] * factor]
    }

    /// Computes pixel `x`.
    fn pixel(&mut self, x: usize) {
        let motion = self.motion[x];
        let whole = motion.map(f32::floor);
        let first = [self.y as f32 + whole[1], x as f32 + whole[0]];
        let [height, width] = [self.input.height, self.input.width];
        let is_near = |at: f32, count: usize| at >= -1.0 && at < count as f32;
        // Also true where the motion is NaN.
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

/// Whether a point at this offset from a pixel's centre lies within the pixel.
#[inline(always)]
fn is_met(place: [f32; 2]) -> bool {
    place.iter().all(|at| (-0.5..0.5).contains(at))
}
