//! Confidence in each depth hypothesis (guess), tile by tile.

use super::depth_hypotheses::{COUNT, DepthHypotheses, OFFSETS, guessed};
use fovol_core::{Frame, FrameSize, Pixel, Reprojection, SparseFrame};
use fovol_simd::{Simd, SimdOp};
use glam::Vec4;
use rayon::prelude::*;
use std::ops::Range;

/// Edge of the tiles in which guesses are judged, in pixels.
pub const TILE: usize = 16;

/// Weights of neighbouring tiles by their distance in rows and in columns.
const NEARBY: [f32; 3] = [1.0, 0.6, 0.2];

/// Factors on the errors of each guess. The nearer and farther guesses must beat the first one clearly: there are many
/// of them, and one always fits by chance.
const HANDICAP: [f32; COUNT] = [1.0, 1.05, 1.05, 1.05, 1.05, 1.0];

/// Exponent of the weights: a guess with twice the squared error of another gets 2^−SHARPNESS times its weight. The
/// weighted mean of distances errs less than the best single guess.
const SHARPNESS: i32 = 5;

/// Squared errors below this are noise.
const NOISE: f32 = 1e-6;

/// Squared error of a sample that lay outside the last frame. A typical value, since such a sample says little about
/// any guess.
const OUTSIDE: f32 = 0.01;

/// Result of weighing all guesses of a distance by their confidence.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DepthConfidence {
    /// Offset to add to the distance interpolated from this frame's samples, in world units.
    pub offset: f32,
    /// Weight of the guess from earlier frames, 0…1.
    pub seen: f32,
}

impl DepthConfidence {
    /// Weighs the guesses by their squared errors.
    fn new(errors: &Errors) -> Self {
        let errors: Errors = std::array::from_fn(|guess| (errors[guess] + NOISE) * HANDICAP[guess]);
        let least = errors.iter().copied().fold(f32::INFINITY, f32::min);
        let trust = errors.map(|error| (least / error).powi(SHARPNESS));
        let near: f32 = trust[..OFFSETS.len()].iter().sum();
        let offsets: f32 = trust.iter().zip(OFFSETS).map(|(trust, offset)| trust * offset).sum();
        let offset = if near > 0.0 { offsets / near } else { 0.0 };
        let seen = trust[OFFSETS.len()];
        Self { offset, seen: seen / (near + seen) }
    }

    /// Interpolates linearly: 0 for `part` gives this, 1 gives `other`.
    #[inline(always)]
    pub fn towards(self, other: Self, part: f32) -> Self {
        let between = |from: f32, to: f32| from + (to - from) * part;
        Self { offset: between(self.offset, other.offset), seen: between(self.seen, other.seen) }
    }
}

/// DepthConfidence of each tile, row by row.
#[derive(Debug, PartialEq)]
pub struct Beliefs {
    columns: usize,
    tiles: Vec<DepthConfidence>,
}

/// Run of pixels in one row, from `pixels.start` on, along which the belief changes linearly.
#[derive(Debug, Clone, PartialEq)]
pub struct Segment {
    pub pixels: Range<usize>,
    /// DepthConfidence at the first pixel.
    first: DepthConfidence,
    /// DepthConfidence at the pixel after the last one of a complete segment.
    end: DepthConfidence,
}

impl Segment {
    /// DepthConfidence at pixel `at` of the segment, counted from its first.
    #[inline(always)]
    pub fn belief(&self, at: usize) -> DepthConfidence {
        self.first.towards(self.end, at as f32 * (1.0 / TILE as f32))
    }
}

impl Beliefs {
    /// Segments of row `y` in a frame of `width` columns. Beliefs are interpolated bilinearly between tile centres, and
    /// constant beyond those at the edges.
    pub fn row(&self, y: usize, width: usize) -> impl Iterator<Item = Segment> {
        let (above, below, part) = between(y, self.tiles.len() / self.columns);
        let belief = move |column: usize| {
            let [above, below] = [above, below].map(|row| self.tiles[row * self.columns + column]);
            above.towards(below, part)
        };
        // Segments reach from one tile centre to the next.
        let starts = (0..=self.columns).map(move |tile| (tile * TILE).saturating_sub(TILE / 2));
        starts.filter(move |start| *start < width).map(move |start| {
            let (left, right, part) = between(start, self.columns);
            let next = if start == 0 { TILE / 2 } else { start + TILE };
            let [left, right] = [left, right].map(belief);
            let first = left.towards(right, part);
            let end = left.towards(right, if start == 0 { part } else { part + 1.0 });
            Segment { pixels: start..next.min(width), first, end }
        })
    }
}

/// The two of `count` tiles in a row whose centres pixel `at` lies between, and the fraction of the way from the first
/// to the second.
fn between(at: usize, count: usize) -> (usize, usize, f32) {
    let place = ((at as f32 + 0.5) / TILE as f32 - 0.5).clamp(0.0, (count - 1) as f32);
    let first = place as usize;
    (first, (first + 1).min(count - 1), place - first as f32)
}

/// Squared error of each guess, summed over the samples of a tile.
type Errors = [f32; COUNT];

/// Weighs the guesses in each tile: the better the `last` frame along a guess's motion matches the samples of `sparse`,
/// the more weight it gets.
///
/// At a sample itself the distance is known, so it cannot test a guess. Each sample is looked up along the motion of an
/// unsampled neighbour instead. Samples take the right and the lower neighbour in turn, or the only unsampled one;
/// using both would tell little more.
pub fn believe(
    guesses: &DepthHypotheses,
    sparse: &SparseFrame,
    to_last: &Reprojection,
    last: &Frame,
) -> Beliefs {
    let size = sparse.size();
    let columns = (size.width as usize).div_ceil(TILE);
    let tiles = columns * (size.height as usize).div_ceil(TILE);
    let evidence = Evidence { guesses, sparse, to_last, last, size };
    let errors: Vec<Errors> =
        (0..tiles).into_par_iter().map(|tile| evidence.of_tile(tile % columns, tile / columns)).collect();
    let belief = |tile: usize| DepthConfidence::new(&around(&errors, columns, tile));
    Beliefs { columns, tiles: (0..tiles).map(belief).collect() }
}

/// Weighted sum of the errors of tile number `tile` and its neighbours, in rows of `columns` tiles.
fn around(errors: &[Errors], columns: usize, tile: usize) -> Errors {
    let (column, row) = (tile % columns, tile / columns);
    let near = |at: usize, end: usize| (at + 1).saturating_sub(NEARBY.len())..(at + NEARBY.len()).min(end);
    let mut sum = [0.0; COUNT];
    for y in near(row, errors.len() / columns) {
        for x in near(column, columns) {
            let share = NEARBY[y.abs_diff(row)] * NEARBY[x.abs_diff(column)];
            for (sum, error) in sum.iter_mut().zip(&errors[y * columns + x]) {
                *sum += share * error;
            }
        }
    }
    sum
}

/// SIMD operation that sums the errors of one tile.
struct TileErrors<'a> {
    evidence: &'a Evidence<'a>,
    tile: [usize; 2],
    errors: &'a mut Errors,
}

impl SimdOp for TileErrors<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.evidence.add_tile(self.tile, self.errors);
    }
}

/// Data against which guesses are judged.
struct Evidence<'a> {
    guesses: &'a DepthHypotheses,
    sparse: &'a SparseFrame,
    to_last: &'a Reprojection,
    last: &'a Frame,
    size: FrameSize,
}

impl Evidence<'_> {
    fn of_tile(&self, column: usize, row: usize) -> Errors {
        let mut errors = [0.0; COUNT];
        Simd::best().vectorised(TileErrors { evidence: self, tile: [column, row], errors: &mut errors });
        errors
    }

    #[inline(always)]
    fn add_tile(&self, [column, row]: [usize; 2], errors: &mut Errors) {
        let [left, top] = [column * TILE, row * TILE];
        let rows = TILE.min(self.size.height as usize - top);
        let mut batch = Batch::default();
        let mut here = self.sampled(left, top);
        for y in top..top + rows {
            let below = self.sampled(left, y + 1);
            // Sampled pixels, and those whose right or lower neighbour is not sampled.
            let sampled = here.are & TILE_BITS;
            let (alone_right, alone_below) = (here.not >> 1, below.not);
            let first_right = EVERY_OTHER << (y % 2);
            let right = alone_right & (first_right | !alone_below);
            let mut found = sampled & (alone_right | alone_below);
            while found != 0 {
                let at = found.trailing_zeros();
                found &= found - 1;
                let x = left + at as usize;
                let beside = if right >> at & 1 == 1 { [x + 1, y] } else { [x, y + 1] };
                let colour = self.sparse.colours()[here.first + here.before(at)];
                self.put([x, y], beside, colour, &mut batch);
                if batch.count == LANES {
                    self.judge(&mut batch, errors);
                }
            }
            here = below;
        }
        self.judge(&mut batch, errors);
    }

    /// Sampling bits of row `y` from column `left` on, for the pixels of a tile and one more.
    #[inline(always)]
    fn sampled(&self, left: usize, y: usize) -> Sampled {
        let (width, height) = (self.size.width as usize, self.size.height as usize);
        if y >= height {
            return Sampled { are: 0, not: 0, first: 0 };
        }
        let end = (left + TILE + 1).min(width);
        let samples = self.sparse.row_part(y, left..end);
        let first = samples.start;
        let bit = |pixel: &Pixel| 1 << (usize::from(pixel.x) - left);
        let are = self.sparse.pixels()[samples].iter().map(bit).fold(0, |all, bit| all | bit);
        Sampled { are, not: !are & (u32::MAX >> (32 - (end - left))), first }
    }

    /// Adds the sample of a colour at pixel `at` to `batch`, to be looked up along the motion of its neighbour `beside`.
    #[inline(always)]
    fn put(&self, at: [usize; 2], beside: [usize; 2], [r, g, b]: [f32; 3], batch: &mut Batch) {
        let lane = batch.count;
        for axis in 0..2 {
            batch.at[axis][lane] = at[axis] as f32;
            batch.beside[axis][lane] = beside[axis] as f32;
        }
        [batch.near[lane], batch.seen[lane]] = self.guesses.inverses(beside);
        batch.colours[lane] = [r, g, b, 1.0];
        batch.count += 1;
    }

    /// Adds the errors of `batch` to `errors`, and empties the batch.
    #[inline(always)]
    fn judge(&self, batch: &mut Batch, errors: &mut Errors) {
        for (guess, error) in errors.iter_mut().enumerate() {
            let mut places = [[0.0f32; LANES]; 2];
            for lane in 0..LANES {
                let inverse = guessed(guess, batch.near[lane], batch.seen[lane]);
                let moved = self.to_last.motion(batch.beside[0][lane], batch.beside[1][lane], inverse);
                for axis in 0..2 {
                    let moved = if inverse > 0.0 { moved[axis] } else { 0.0 };
                    places[axis][lane] = batch.at[axis][lane] + moved;
                }
            }
            let (mut sum, mut outside) = (Vec4::ZERO, 0.0);
            for lane in 0..batch.count {
                match self.difference([places[0][lane], places[1][lane]], batch.colours[lane]) {
                    Some(way) => sum += way * way,
                    None => outside += OUTSIDE,
                }
            }
            *error += sum.element_sum() * (1.0 / 3.0) + outside;
        }
        batch.count = 0;
    }

    /// Difference of the last frame at `place` (bilinear) and `colour`, both with alpha 1. `None` if `place` lies
    /// outside the frame.
    #[inline(always)]
    fn difference(&self, place: [f32; 2], colour: [f32; 4]) -> Option<Vec4> {
        let (width, height) = (self.size.width as usize, self.size.height as usize);
        let [x, y] = place;
        if !(x >= 0.0 && y >= 0.0 && x <= (width - 1) as f32 && y <= (height - 1) as f32) {
            return None;
        }
        // Casts to 32 bits take a single instruction, and suffice.
        let (x0, y0) = (x as i32, y as i32);
        let (right, down) = (x - x0 as f32, y - y0 as f32);
        let (x0, y0) = (x0 as usize, y0 as usize);
        let (x1, y1) = ((x0 + 1).min(width - 1), (y0 + 1).min(height - 1));
        let at = |x: usize, y: usize| Vec4::from_array(self.last.pixels()[y * width + x]);
        let between = |from: Vec4, to: Vec4, part: f32| from + (to - from) * part;
        let above = between(at(x0, y0), at(x1, y0), right);
        let below = between(at(x0, y1), at(x1, y1), right);
        Some(between(above, below, down) - Vec4::from_array(colour))
    }
}

/// Sampling of a row's pixels, one bit each.
#[derive(Clone, Copy)]
struct Sampled {
    are: u32,
    /// Pixels inside the frame that are not sampled.
    not: u32,
    /// Index of the first sample.
    first: usize,
}

impl Sampled {
    /// Number of samples before pixel `at`.
    #[inline(always)]
    fn before(&self, at: u32) -> usize {
        (self.are & ((1 << at) - 1)).count_ones() as usize
    }
}

/// Bits of the pixels of one tile row.
const TILE_BITS: u32 = (1 << TILE) - 1;

/// Bits of every other pixel, beginning with the first.
const EVERY_OTHER: u32 = 0x5555_5555;

/// Pairs of pixels judged at once.
const LANES: usize = 16;

/// Sampled pixels and their unsampled neighbours.
#[derive(Default)]
struct Batch {
    count: usize,
    at: [[f32; LANES]; 2],
    beside: [[f32; LANES]; 2],
    /// Inverse distances of the neighbours, from this frame and from earlier frames: see [`DepthHypotheses::inverses`].
    near: [f32; LANES],
    seen: [f32; LANES],
    /// Colours of the sampled pixels.
    colours: [[f32; 4]; LANES],
}

#[cfg(test)]
mod tests {
    use super::super::Depths;
    use super::*;
    use fovol_core::{Camera, SampleList};

    const SIZE: FrameSize = FrameSize { width: 96, height: 64 };

    /// Colour of a patterned wall at pixel (`x`, `y`).
    fn pattern(x: f32, y: f32) -> f32 {
        0.5 + 0.25 * (0.3 * x).sin() + 0.25 * (0.2 * y + 0.1 * x).cos()
    }

    /// Motion found where the true inverse distance of samples is `true_inverse` and the stated one is `told_inverse`.
    fn found(true_inverse: f32, told_inverse: f32, earlier: Option<f32>) -> Vec<[f32; 2]> {
        let [there, here] = [0.0, 10.0].map(|azimuth| Camera::on_sphere(azimuth, 5.0, 2.0, 40.0));
        let to_last = Reprojection::new(&here, &there, SIZE);
        let mut last = Frame::new(SIZE);
        let (mut told, mut colours, mut before) = (Vec::new(), Vec::new(), Vec::new());
        for y in 0..64u16 {
            for x in 0..96u16 {
                let pixel = Pixel { x, y };
                let [x, y] = [x, y].map(f32::from);
                last.pixels_mut()[pixel.index(96)] = [pattern(x, y), 0.5, 0.5, 1.0];
                if (pixel.x + 5 * pixel.y).is_multiple_of(11) {
                    let [dx, dy] = to_last.motion(x, y, true_inverse);
                    colours.push([pattern(x + dx, y + dy), 0.5, 0.5]);
                    told.push(pixel);
                } else if earlier.is_some() {
                    before.push(pixel);
                }
            }
        }
        let sparse = |pixels: Vec<Pixel>, colours: Vec<[f32; 3]>, inverse: f32| {
            let depths = vec![1.0 / inverse; pixels.len()];
            SparseFrame::new(SampleList::new(SIZE, pixels), colours, depths)
        };
        let now = sparse(told, colours, told_inverse);
        let nothing = vec![[0.0; 3]; before.len()];
        let before = Depths::new(&sparse(before, nothing, earlier.unwrap_or(1.0)));
        let earlier = [(Reprojection::new(&here, &here, SIZE), &before)];
        super::super::motion(&now, &earlier, &to_last, &last)
    }

    #[test]
    fn distances_are_corrected_by_what_the_last_frame_shows() {
        let [there, here] = [0.0, 10.0].map(|azimuth| Camera::on_sphere(azimuth, 5.0, 2.0, 40.0));
        let to_last = Reprojection::new(&here, &there, SIZE);
        let wrong = |motion: [f32; 2], inverse: f32| {
            let expected = to_last.motion(48.0, 32.0, inverse);
            (motion[0] - expected[0]).abs() + (motion[1] - expected[1]).abs()
        };
        let middle = 32 * 96 + 48;
        for told in [0.5, 1.0 / 2.1, 1.0 / 1.9, 1.0 / 1.8, 1.0 / 2.2] {
            let motion = found(0.5, told, None)[middle];
            let [wrong, told_wrong] = [0.5, told].map(|inverse| wrong(motion, inverse));
            assert!(wrong < 0.1 && (told == 0.5 || wrong < 0.3 * told_wrong), "{told}: {wrong} {told_wrong}");
        }
        // No guess from this frame fits, but the guess from earlier frames does.
        let motion = found(0.5, 0.9, Some(0.5))[middle];
        assert!(wrong(motion, 0.5) < 0.1, "{motion:?}");
    }

    #[test]
    fn tiles_at_the_edge_are_judged_with_those_that_there_are() {
        let mut errors = vec![[1.0; COUNT]; 6];
        errors[5][3] = 0.0;
        let sum = around(&errors, 3, 0);
        assert!(
            (sum[0] - 1.8 * 1.6).abs() < 1e-6 && (sum[3] - (1.8 * 1.6 - 0.2 * 0.6)).abs() < 1e-6,
            "{sum:?}"
        );
    }

    #[test]
    fn guesses_are_believed_as_they_fit() {
        let nothing = DepthConfidence::new(&[0.0; COUNT]);
        assert!(nothing.offset == 0.0 && nothing.seen < 0.25, "{nothing:?}");
        let nearer = DepthConfidence::new(&[1.0, 0.01, 1.0, 1.0, 1.0, 1.0]);
        assert!((nearer.offset + 0.1).abs() < 1e-3 && nearer.seen < 1e-3, "{nearer:?}");
        let between = DepthConfidence::new(&[1.0, 0.01, 1.0, 0.01, 1.0, 1.0]);
        assert!((between.offset + 0.15).abs() < 1e-3, "{between:?}");
        let seen = DepthConfidence::new(&[1.0, 1.0, 1.0, 1.0, 1.0, 0.0]);
        assert!(seen.offset == 0.0 && seen.seen == 1.0, "{seen:?}");
    }

    #[test]
    fn beliefs_change_evenly_between_the_middles_of_tiles() {
        let tiles =
            (0..6).map(|i| DepthConfidence { offset: (i % 3) as f32, seen: (i / 3) as f32 }).collect();
        let beliefs = Beliefs { columns: 3, tiles };
        for (y, width) in [(0, 48), (7, 33), (8, 41), (20, 40), (31, 48)] {
            let mut x = 0;
            for segment in beliefs.row(y, width) {
                assert_eq!(segment.pixels.start, x);
                for at in 0..segment.pixels.len() {
                    let belief = segment.belief(at);
                    let expected = |at: usize, last: f32| ((at as f32 - 7.5) / 16.0).clamp(0.0, last);
                    assert!((belief.offset - expected(x, 2.0)).abs() < 1e-5, "{x} {belief:?}");
                    assert!((belief.seen - expected(y, 1.0)).abs() < 1e-5, "{y} {belief:?}");
                    x += 1;
                }
            }
            assert_eq!(x, width);
        }
    }
}
