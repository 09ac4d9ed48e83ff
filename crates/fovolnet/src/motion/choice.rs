//! Which guess of distances is believed where.

use super::guesses::{COUNT, Guesses};
use fovol_core::{Frame, FrameSize, Reprojection};
use rayon::prelude::*;

/// Edge of the tiles that a guess is chosen for, in pixels.
pub const TILE: usize = 16;

/// Tiles to each side whose samples count too.
const AROUND: usize = 2;

/// How much better than the first guess others have to be, by their number: nearer and farther ones are many, and one of them
/// always fits by chance.
const HANDICAP: [f32; COUNT] = [1.0, 1.05, 1.05, 1.05, 1.05, 1.0];

/// The squared error of what lay outside the last frame.
const OUTSIDE: f32 = 1.0;

/// The number of the guess that is believed, tile by tile.
#[derive(Debug, PartialEq)]
pub struct Chosen {
    columns: usize,
    guesses: Vec<u8>,
}

impl Chosen {
    /// For pixel (`x`, `y`).
    #[inline(always)]
    pub fn guess(&self, x: usize, y: usize) -> usize {
        usize::from(self.guesses[y / TILE * self.columns + x / TILE])
    }
}

/// Squared errors of each guess, of all samples of a tile.
type Errors = [f32; COUNT];

/// Chooses for each tile the guess along which `last` differs least from the samples of `sparse`. At a sample itself the distance
/// is known and guesses agree: each sample is looked for along the motion of the pixels right of it and below it.
pub fn choose(guesses: &Guesses, sparse: &Frame, to_last: &Reprojection, last: &Frame) -> Chosen {
    let size = sparse.size();
    let columns = (size.width as usize).div_ceil(TILE);
    let tiles = columns * (size.height as usize).div_ceil(TILE);
    let evidence = Evidence { guesses, sparse, to_last, last, size };
    let errors: Vec<Errors> =
        (0..tiles).into_par_iter().map(|tile| evidence.of_tile(tile % columns, tile / columns)).collect();
    let best = |tile: usize| best(&around(&errors, columns, tile));
    Chosen { columns, guesses: (0..tiles).map(best).collect() }
}

/// The number of the guess with the least errors.
fn best(errors: &Errors) -> u8 {
    let mut best = 0;
    for guess in 1..COUNT {
        if errors[guess] * HANDICAP[guess] < errors[best] * HANDICAP[best] {
            best = guess;
        }
    }
    best as u8
}

/// The errors of tile number `tile` and of those around it, in rows of `columns`.
fn around(errors: &[Errors], columns: usize, tile: usize) -> Errors {
    let (column, row) = (tile % columns, tile / columns);
    let near = |at: usize, end: usize| at.saturating_sub(AROUND)..(at + AROUND + 1).min(end);
    let mut sum = [0.0; COUNT];
    for row in near(row, errors.len() / columns) {
        for column in near(column, columns) {
            for (sum, error) in sum.iter_mut().zip(&errors[row * columns + column]) {
                *sum += error;
            }
        }
    }
    sum
}

/// What guesses are judged by.
struct Evidence<'a> {
    guesses: &'a Guesses,
    sparse: &'a Frame,
    to_last: &'a Reprojection,
    last: &'a Frame,
    size: FrameSize,
}

impl Evidence<'_> {
    fn of_tile(&self, column: usize, row: usize) -> Errors {
        let (width, height) = (self.size.width as usize, self.size.height as usize);
        let pixels = |at: usize, end: usize| at * TILE..((at + 1) * TILE).min(end);
        let mut errors = [0.0; COUNT];
        for y in pixels(row, height) {
            for x in pixels(column, width) {
                let colour = self.sparse.pixels()[y * width + x];
                if colour[3] > 0.5 {
                    for (x1, y1) in [(x + 1, y), (x, y + 1)] {
                        if x1 < width && y1 < height {
                            self.add([x, y], [x1, y1], colour, &mut errors);
                        }
                    }
                }
            }
        }
        errors
    }

    /// The errors of looking for the `colour` of pixel `at` along the motion of pixel `beside`.
    #[inline(always)]
    fn add(&self, at: [usize; 2], beside: [usize; 2], colour: [f32; 4], errors: &mut Errors) {
        let i = beside[1] * self.size.width as usize + beside[0];
        let [x, y] = at.map(|c| c as f32);
        for (guess, error) in errors.iter_mut().enumerate() {
            let inverse = self.guesses.inverse(guess, i);
            let moved = if inverse > 0.0 {
                self.to_last.motion(beside[0] as f32, beside[1] as f32, inverse)
            } else {
                [0.0; 2]
            };
            *error += self.difference([x + moved[0], y + moved[1]], colour);
        }
    }

    /// The squared difference of `colour` and the last frame at `place`.
    #[inline(always)]
    fn difference(&self, place: [f32; 2], colour: [f32; 4]) -> f32 {
        let (width, height) = (self.size.width as usize, self.size.height as usize);
        let [x, y] = place;
        if !(x >= 0.0 && y >= 0.0 && x <= (width - 1) as f32 && y <= (height - 1) as f32) {
            return OUTSIDE;
        }
        let (x0, y0) = (x as usize, y as usize);
        let (x1, y1) = ((x0 + 1).min(width - 1), (y0 + 1).min(height - 1));
        let (right, down) = (x - x0 as f32, y - y0 as f32);
        let [a, b, c, d] =
            [(x0, y0), (x1, y0), (x0, y1), (x1, y1)].map(|(x, y)| self.last.pixels()[y * width + x]);
        let mut sum = 0.0;
        for i in 0..3 {
            let above = a[i] + (b[i] - a[i]) * right;
            let below = c[i] + (d[i] - c[i]) * right;
            sum += (above + (below - above) * down - colour[i]).powi(2);
        }
        sum * (1.0 / 3.0)
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Depths, Sparse};
    use super::*;
    use fovol_core::{Camera, Pixel};

    const SIZE: FrameSize = FrameSize { width: 96, height: 64 };

    /// What a wall with a pattern on it looks like at pixel (`x`, `y`).
    fn pattern(x: f32, y: f32) -> f32 {
        0.5 + 0.25 * (0.9 * x).sin() + 0.25 * (0.7 * y + 0.3 * x).cos()
    }

    /// The motions that are found where samples lie `true_inverse` away, but say `told_inverse`.
    fn found(true_inverse: f32, told_inverse: f32, earlier: Option<f32>) -> Vec<[f32; 2]> {
        let [there, here] = [0.0, 3.0].map(|azimuth| Camera::on_sphere(azimuth, 5.0, 2.0, 40.0));
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
        let [there, here] = [0.0, 3.0].map(|azimuth| Camera::on_sphere(azimuth, 5.0, 2.0, 40.0));
        let to_last = Reprojection::new(&here, &there, SIZE);
        let middle = 32 * 96 + 48;
        let expected = to_last.motion(48.0, 32.0, 0.5);
        let near = |[x, y]: [f32; 2]| (x - expected[0]).abs() + (y - expected[1]).abs();
        for told in [0.5, 1.0 / 2.1, 1.0 / 1.9, 1.0 / 1.8, 1.0 / 2.2] {
            let motion = found(0.5, told, None);
            assert!(near(motion[middle]) < 1e-3, "{told}: {:?} {expected:?}", motion[middle]);
        }
        // Nothing of this frame fits, but what was seen before does beside its samples.
        let motion = found(0.5, 0.9, Some(0.5));
        assert!(near(motion[middle]) < 1e-3, "{:?} {expected:?}", motion[middle]);
    }

    #[test]
    fn tiles_at_the_edge_are_judged_with_those_that_there_are() {
        let mut errors = vec![[1.0; COUNT]; 6];
        errors[5][3] = 0.0;
        assert_eq!(around(&errors, 3, 0)[3], 5.0);
        assert_eq!(best(&around(&errors, 3, 0)), 3);
        // A little better is not enough where it fits by chance.
        assert_eq!(best(&[1.0, 0.98, 1.0, 1.0, 1.0, 1.0]), 0);
        assert_eq!(best(&[1.0, 0.98, 1.0, 1.0, 1.0, 0.99]), 5);
    }
}
