//! How far guesses of distances are believed where.

use super::depth_hypotheses::{COUNT, DepthHypotheses, OFFSETS, guessed};
use fovol_core::{Frame, FrameSize, Reprojection};
use fovol_net::cpu::{Simd, SimdOp};
use glam::Vec4;
use rayon::prelude::*;
use std::ops::Range;

/// Edge of the tiles that guesses are judged in, in pixels.
pub const TILE: usize = 16;

/// How much the samples of tiles to each side count, by their distance in rows and in columns.
const NEARBY: [f32; 3] = [1.0, 0.6, 0.2];

/// How much better than the first guess others have to be, by their number: nearer and farther ones are many, and one of them
/// always fits by chance.
const HANDICAP: [f32; COUNT] = [1.0, 1.05, 1.05, 1.05, 1.05, 1.0];

/// A guess with twice the errors of another is believed 2 to the power of minus this as much: the expected distance errs less than the
/// likeliest one.
const SHARPNESS: i32 = 5;

/// Squared errors below this tell nothing.
const NOISE: f32 = 1e-6;

/// The squared error of what lay outside the last frame: a usual one, as it says little about any guess.
const OUTSIDE: f32 = 0.01;

/// What comes of all guesses of a distance, each as far as it is believed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DepthConfidence {
    /// To be added to the distance between this frame's samples, in world units.
    pub offset: f32,
    /// How far the guess from earlier frames is believed: 0 not at all, 1 alone.
    pub seen: f32,
}

impl DepthConfidence {
    /// From the errors of each guess.
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

    /// `part` of the way to `other`.
    #[inline(always)]
    pub fn towards(self, other: Self, part: f32) -> Self {
        let between = |from: f32, to: f32| from + (to - from) * part;
        Self { offset: between(self.offset, other.offset), seen: between(self.seen, other.seen) }
    }
}

/// Beliefs tile by tile.
#[derive(Debug, PartialEq)]
pub struct Beliefs {
    columns: usize,
    tiles: Vec<DepthConfidence>,
}

/// The beliefs in a row of pixels from `pixels.start` on, where they change evenly.
#[derive(Debug, Clone, PartialEq)]
pub struct Segment {
    pub pixels: Range<usize>,
    /// At the first pixel.
    first: DepthConfidence,
    /// At the pixel after the last one of a whole segment.
    end: DepthConfidence,
}

impl Segment {
    /// At the pixel that is number `at` of the segment.
    #[inline(always)]
    pub fn belief(&self, at: usize) -> DepthConfidence {
        self.first.towards(self.end, at as f32 * (1.0 / TILE as f32))
    }
}

impl Beliefs {
    /// In row `y` of a frame of this `width`: between the middles of tiles, and beyond those at the edges.
    pub fn row(&self, y: usize, width: usize) -> impl Iterator<Item = Segment> {
        let (above, below, part) = between(y, self.tiles.len() / self.columns);
        let belief = move |column: usize| {
            let [above, below] = [above, below].map(|row| self.tiles[row * self.columns + column]);
            above.towards(below, part)
        };
        // From the middle of a tile to that of the next.
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

/// The tiles, of `count` in a row, between whose middles pixel `at` lies, and which part of the way it is from one to the other.
fn between(at: usize, count: usize) -> (usize, usize, f32) {
    let place = ((at as f32 + 0.5) / TILE as f32 - 0.5).clamp(0.0, (count - 1) as f32);
    let first = place as usize;
    (first, (first + 1).min(count - 1), place - first as f32)
}

/// Squared errors of each guess, of all samples of a tile.
type Errors = [f32; COUNT];

/// Believes in each tile the guesses the more, the less `last` differs along them from the samples of `sparse`. At a sample itself
/// the distance is known: each sample is looked for along the motion of a pixel beside it that was not sampled too, every other
/// one along that of the pixel right of it if it can be, the rest along that of the pixel below. Both would tell nearly the same.
pub fn believe(guesses: &DepthHypotheses, sparse: &Frame, to_last: &Reprojection, last: &Frame) -> Beliefs {
    let size = sparse.size();
    let columns = (size.width as usize).div_ceil(TILE);
    let tiles = columns * (size.height as usize).div_ceil(TILE);
    let evidence = Evidence { guesses, sparse, to_last, last, size };
    let errors: Vec<Errors> =
        (0..tiles).into_par_iter().map(|tile| evidence.of_tile(tile % columns, tile / columns)).collect();
    let belief = |tile: usize| DepthConfidence::new(&around(&errors, columns, tile));
    Beliefs { columns, tiles: (0..tiles).map(belief).collect() }
}

/// The errors of tile number `tile` and of those around it, in rows of `columns`.
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

/// The finding of the errors of a tile.
struct TileErrors<'a> {
    evidence: &'a Evidence<'a>,
    tile: [usize; 2],
    errors: &'a mut Errors,
}

impl SimdOp for TileErrors<'_> {
    #[inline(always)]
    fn run(self) {
        self.evidence.add_tile(self.tile, self.errors);
    }
}

/// What guesses are judged by.
struct Evidence<'a> {
    guesses: &'a DepthHypotheses,
    sparse: &'a Frame,
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
            // Pixels that are sampled, and those right of and below which none is.
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
                self.put([x, y], beside, &mut batch);
                if batch.count == LANES {
                    self.judge(&mut batch, errors);
                }
            }
            here = below;
        }
        self.judge(&mut batch, errors);
    }

    /// Which pixels of a row are sampled, from column `left` on, those of a tile and one more.
    #[inline(always)]
    fn sampled(&self, left: usize, y: usize) -> Sampled {
        let (width, height) = (self.size.width as usize, self.size.height as usize);
        let mut found = Sampled { are: 0, not: 0 };
        if y < height {
            let end = (left + TILE + 1).min(width);
            for (at, pixel) in self.sparse.pixels()[y * width..][left..end].iter().enumerate() {
                found.are |= u32::from(pixel[3] > 0.5) << at;
            }
            found.not = !found.are & (u32::MAX >> (32 - (end - left)));
        }
        found
    }

    /// Adds the looking for the colour of pixel `at` along the motion of pixel `beside` to `batch`.
    #[inline(always)]
    fn put(&self, at: [usize; 2], beside: [usize; 2], batch: &mut Batch) {
        let lane = batch.count;
        for axis in 0..2 {
            batch.at[axis][lane] = at[axis] as f32;
            batch.beside[axis][lane] = beside[axis] as f32;
        }
        [batch.near[lane], batch.seen[lane]] = self.guesses.inverses(beside);
        batch.colours[lane] = self.sparse.pixels()[at[1] * self.size.width as usize + at[0]];
        batch.count += 1;
    }

    /// Adds the errors of `batch`, which is empty then.
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

    /// The difference of `colour` and the last frame at `place`, both of alpha 1; none outside it.
    #[inline(always)]
    fn difference(&self, place: [f32; 2], colour: [f32; 4]) -> Option<Vec4> {
        let (width, height) = (self.size.width as usize, self.size.height as usize);
        let [x, y] = place;
        if !(x >= 0.0 && y >= 0.0 && x <= (width - 1) as f32 && y <= (height - 1) as f32) {
            return None;
        }
        // 32 bits are enough, and take one instruction.
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

/// Pixels of a row, a bit each.
#[derive(Clone, Copy)]
struct Sampled {
    are: u32,
    /// Those that are in the frame and not sampled.
    not: u32,
}

/// The bits of a tile's pixels.
const TILE_BITS: u32 = (1 << TILE) - 1;

/// The bits of every other pixel, from the first of an even row on.
const EVERY_OTHER: u32 = 0x5555_5555;

/// Pairs of pixels that are judged at once.
const LANES: usize = 16;

/// Sampled pixels and those beside them.
#[derive(Default)]
struct Batch {
    count: usize,
    at: [[f32; LANES]; 2],
    beside: [[f32; LANES]; 2],
    /// One over the distances of those beside them: see [`DepthHypotheses::inverses`].
    near: [f32; LANES],
    seen: [f32; LANES],
    /// Of the sampled ones.
    colours: [[f32; 4]; LANES],
}

#[cfg(test)]
mod tests {
    use super::super::{Depths, Sparse};
    use super::*;
    use fovol_core::{Camera, Pixel};

    const SIZE: FrameSize = FrameSize { width: 96, height: 64 };

    /// What a wall with a pattern on it looks like at pixel (`x`, `y`).
    fn pattern(x: f32, y: f32) -> f32 {
        0.5 + 0.25 * (0.3 * x).sin() + 0.25 * (0.2 * y + 0.1 * x).cos()
    }

    /// The motions that are found where samples lie `true_inverse` away, but say `told_inverse`.
    fn found(true_inverse: f32, told_inverse: f32, earlier: Option<f32>) -> Vec<[f32; 2]> {
        let [there, here] = [0.0, 10.0].map(|azimuth| Camera::on_sphere(azimuth, 5.0, 2.0, 40.0));
        let to_last = Reprojection::new(&here, &there, SIZE);
        let mut last = Frame::new(SIZE);
        let (mut sparse, mut told, mut before) = (Frame::new(SIZE), Vec::new(), Vec::new());
        for y in 0..64u16 {
            for x in 0..96u16 {
                let pixel = Pixel { x, y };
                let [x, y] = [x, y].map(f32::from);
                last.pixels_mut()[pixel.index(96)] = [pattern(x, y), 0.5, 0.5, 1.0];
                if (pixel.x + 5 * pixel.y).is_multiple_of(11) {
                    let [dx, dy] = to_last.motion(x, y, true_inverse);
                    sparse.pixels_mut()[pixel.index(96)] = [pattern(x + dx, y + dy), 0.5, 0.5, 1.0];
                    told.push((pixel, told_inverse));
                } else if let Some(earlier) = earlier {
                    before.push((pixel, earlier));
                }
            }
        }
        let (told, before) = (Depths::of_inverse(SIZE, told), Depths::of_inverse(SIZE, before));
        let earlier = [(Reprojection::new(&here, &here, SIZE), &before)];
        super::super::motion(Sparse { frame: &sparse, depths: &told }, &earlier, &to_last, &last)
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
        // Nothing of this frame fits, but what was seen before does beside its samples.
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
