//! Samples of earlier frames as points, each with its place in its pixel.

use super::map::Map;
use super::pyramid::{Known, KnownRows};
use super::simd::{Simd, Work};
use crate::plan::POINT;
use glam::Vec4;
use rayon::prelude::*;

/// What is known of a pixel of earlier frames, and how far right of and below its centre.
pub type Point = [f32; POINT];

/// Nothing.
const NONE: Point = [0.0; POINT];

#[inline(always)]
fn known([r, g, b, w, ..]: &Point) -> Vec4 {
    Vec4::new(*r, *g, *b, *w)
}

#[inline(always)]
fn point(known: Vec4, [x, y]: [f32; 2]) -> Point {
    let [r, g, b, w] = known.to_array();
    [r, g, b, w, x, y]
}

/// The points of row `y` of `map`.
pub fn row(map: &Map, y: usize) -> &[Point] {
    map.row(y).as_chunks().0
}

/// Writes to `out` the points of `input` where `motion`, in pixels to the previous position, takes them (see
/// [`Layer::Reproject`](crate::plan::Layer::Reproject)).
pub fn reproject(input: &Map, motion: &Map, out: &mut Map) {
    let [height, width] = [input.height, input.width];
    out.resize([height, width, POINT]);
    out.data.par_chunks_mut(width * POINT).enumerate().for_each(|(y, to)| {
        let (motion, to) = (motion.row(y).as_chunks().0, to.as_chunks_mut().0);
        Simd::best().vectorised(ReprojectRow { input, motion, y, to });
    });
}

struct ReprojectRow<'a> {
    input: &'a Map,
    motion: &'a [[f32; 2]],
    y: usize,
    to: &'a mut [Point],
}

impl Work for ReprojectRow<'_> {
    #[inline(always)]
    fn run(self) {
        let Self { input, motion, y, to } = self;
        let points = input.data.as_chunks().0;
        let limits = [input.width as f32, input.height as f32];
        for (x, (to, motion)) in to.iter_mut().zip(motion).enumerate() {
            let whole = motion.map(f32::floor);
            let [left, above] = [x as f32 + whole[0], y as f32 + whole[1]];
            // Also where the motion is no number.
            if !(left >= -1.0 && left < limits[0] && above >= -1.0 && above < limits[1]) {
                *to = NONE;
                continue;
            }
            let part = [motion[0] - whole[0], motion[1] - whole[1]];
            *to = met(points, [input.height, input.width], [above as isize, left as isize], part);
        }
    }
}

/// The mean of those of the four `points` from row and column `first` on that lie in the square of a pixel's size around
/// `part` of the way from the first to the last, with the largest of their weights. Their places are counted from there.
#[inline(always)]
fn met(
    points: &[Point],
    [height, width]: [usize; 2],
    [above, left]: [isize; 2],
    [right, down]: [f32; 2],
) -> Point {
    let (mut sum, mut places, mut largest) = (Vec4::ZERO, [0.0; 2], 0.0f32);
    for corner in 0..4 {
        let steps = [corner & 1, corner >> 1];
        let (row, column) = (above + steps[1], left + steps[0]);
        if row < 0 || row >= height as isize || column < 0 || column >= width as isize {
            continue;
        }
        let from = &points[row as usize * width + column as usize];
        let place = [from[4] + (steps[0] as f32 - right), from[5] + (steps[1] as f32 - down)];
        let is_met = from[3] > 0.0 && place.iter().all(|at| (-0.5..0.5).contains(at));
        if is_met {
            sum += known(from);
            places = [places[0] + from[3] * place[0], places[1] + from[3] * place[1]];
            largest = largest.max(from[3]);
        }
    }
    if largest == 0.0 {
        return NONE;
    }
    let factor = 1.0 / sum.w;
    point(sum * (largest * factor), places.map(|place| place * factor))
}

/// Writes to `out` what the points of `input` tell of the centres of pixels (see [`Layer::Splat`](crate::plan::Layer::Splat)).
pub fn splat(input: &Map, out: &mut Map) {
    let [height, width] = [input.height, input.width];
    out.resize([height, width, 4]);
    out.data.par_chunks_mut(width * 4).enumerate().for_each_init(Vec::new, |shares, (y, to)| {
        shares.resize(width, 0.0);
        Simd::best().vectorised(SplatRow { input, y, shares, to: to.as_chunks_mut().0 });
    });
}

struct SplatRow<'a> {
    input: &'a Map,
    y: usize,
    /// What divides each pixel.
    shares: &'a mut [f32],
    to: &'a mut [Known],
}

impl Work for SplatRow<'_> {
    #[inline(always)]
    fn run(self) {
        let Self { input, y, shares, to } = self;
        to.fill([0.0; 4]);
        shares.fill(0.0);
        for from in y.saturating_sub(1)..(y + 2).min(input.height) {
            let below = from as f32 - y as f32;
            for (x, point) in row(input, from).iter().enumerate() {
                let near = 1.0 - (point[5] + below).abs();
                if point[3] <= 0.0 || near <= 0.0 {
                    continue;
                }
                // The centre that is left of the point or above it, and how far on to the next one it lies.
                let (left, part) =
                    if point[4] < 0.0 { (x.wrapping_sub(1), point[4] + 1.0) } else { (x, point[4]) };
                for (at, share) in [(left, near * (1.0 - part)), (left.wrapping_add(1), near * part)] {
                    if at < to.len() {
                        to[at] = (Vec4::from_array(to[at]) + share * known(point)).to_array();
                        shares[at] += share;
                    }
                }
            }
        }
        for (to, share) in to.iter_mut().zip(shares) {
            *to = (Vec4::from_array(*to) * (1.0 / share.max(1.0))).to_array();
        }
    }
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
        to.clear();
        to.extend(row(self.0, y).iter().map(|point| known(point).to_array()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: [usize; 2] = [6, 8];

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
