use super::depth_confidence::{Beliefs, DepthConfidence};
use super::{Depths, Sparse};
use fovol_core::{FrameSize, Reprojection};
use fovol_net::FilledNumbers;
use fovol_net::cpu::{Simd, SimdOp};
use rayon::prelude::*;

/// How far away everything could be, one guess after the other. Distances are in world units: the volume's longest side is 1.
#[derive(Debug)]
pub struct DepthHypotheses {
    /// One over the distances between the samples of this frame, and between these and those of earlier frames.
    filled: FilledNumbers,
}

/// What is added to the distances between this frame's samples, guess by guess; the guess after these is of earlier frames too.
pub const OFFSETS: [f32; 5] = [0.0, -0.1, 0.1, -0.2, 0.2];

/// How many guesses there are.
pub const COUNT: usize = OFFSETS.len() + 1;

/// No distance is below this.
pub const NEAREST: f32 = 0.05;

impl DepthHypotheses {
    pub fn new(now: Sparse<'_>, earlier: &[(Reprojection, &Depths)]) -> Self {
        Self { filled: now.depths.filled_with(earlier) }
    }

    pub fn size(&self) -> FrameSize {
        self.filled.size()
    }

    /// One over the distance of a pixel between the samples of this frame, and between these and those of earlier frames; 0 where
    /// nothing is known.
    #[inline(always)]
    pub fn inverses(&self, pixel: [usize; 2]) -> [f32; 2] {
        self.filled.at(pixel)
    }

    /// The motion along the guesses, each as far as `beliefs` believe it.
    pub fn motion(&self, beliefs: &Beliefs, to_last: &Reprojection) -> Vec<[f32; 2]> {
        let width = self.size().width as usize;
        let mut motion = vec![[0.0; 2]; self.size().pixels()];
        let rows = motion.par_chunks_mut(width).enumerate();
        rows.for_each_init(Memory::default, |memory, (y, row)| {
            let motion = MotionOfRow { guesses: self, beliefs, to_last, y, memory, row };
            Simd::best().vectorised(motion);
        });
        motion
    }
}

/// The numbers of a row.
#[derive(Default)]
struct Memory {
    near: Vec<f32>,
    seen: Vec<f32>,
    line: Vec<f32>,
}

/// The motion of the pixels of a row.
struct MotionOfRow<'a> {
    guesses: &'a DepthHypotheses,
    beliefs: &'a Beliefs,
    to_last: &'a Reprojection,
    y: usize,
    memory: &'a mut Memory,
    row: &'a mut [[f32; 2]],
}

impl SimdOp for MotionOfRow<'_> {
    #[inline(always)]
    fn run(self) {
        let Self { guesses, beliefs, to_last, y, memory, row } = self;
        let Memory { near, seen, line } = memory;
        near.resize(row.len(), 0.0);
        seen.resize(row.len(), 0.0);
        guesses.filled.row(y, [near, seen], line);
        for segment in beliefs.row(y, row.len()) {
            let (near, seen) = (&mut near[segment.pixels.clone()], &seen[segment.pixels.clone()]);
            for (at, (near, seen)) in near.iter_mut().zip(seen).enumerate() {
                *near = believed(segment.belief(at), *near, *seen);
            }
        }
        put_motion(row, y, to_last, near);
    }
}

/// One over the distance that is believed where `near` and `seen` are guesses of it.
#[inline(always)]
fn believed(belief: DepthConfidence, near: f32, seen: f32) -> f32 {
    let near = moved_by(near, belief.offset);
    if near > 0.0 { near + (seen - near) * belief.seen } else { seen }
}

/// One over the distance of a pixel as guess number `guess` has it, where it is `near` and `seen`: see [`DepthHypotheses::inverses`].
#[inline(always)]
pub fn guessed(guess: usize, near: f32, seen: f32) -> f32 {
    OFFSETS.get(guess).map_or(seen, |offset| moved_by(near, *offset))
}

/// `inverse`, one over a distance, with `offset` added to that.
#[inline(always)]
fn moved_by(inverse: f32, offset: f32) -> f32 {
    if inverse > 0.0 && offset != 0.0 { 1.0 / (1.0 / inverse + offset).max(NEAREST) } else { inverse }
}

/// The motion of the pixels of a frame of `size` that are one over `inverse` away.
pub fn motion_of(size: FrameSize, reprojection: &Reprojection, inverse: &[f32]) -> Vec<[f32; 2]> {
    let width = size.width as usize;
    let mut motion = vec![[0.0; 2]; size.pixels()];
    motion.par_chunks_mut(width).zip(inverse.par_chunks(width)).enumerate().for_each(
        |(y, (row, inverse))| {
            put_motion(row, y, reprojection, inverse);
        },
    );
    motion
}

/// The motion of the pixels of row `y`, each one over `inverse` away; none where that is 0.
#[inline(always)]
fn put_motion(row: &mut [[f32; 2]], y: usize, reprojection: &Reprojection, inverse: &[f32]) {
    for (x, (to, inverse)) in row.iter_mut().zip(inverse).enumerate() {
        let moved = reprojection.motion(x as f32, y as f32, *inverse);
        *to = if *inverse > 0.0 { moved } else { [0.0; 2] };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_known_stays_unknown_and_nothing_comes_behind_the_eye() {
        assert!(moved_by(0.0, 0.1) == 0.0);
        assert!((moved_by(0.5, 0.1) - 1.0 / 2.1).abs() < 1e-6);
        assert!((moved_by(10.0, -0.2) - 1.0 / NEAREST).abs() < 1e-6);
    }
}
