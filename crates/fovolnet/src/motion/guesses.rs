use super::belief::{Belief, Beliefs, Segment};
use super::{Depths, Filled, Sparse};
use fovol_core::{FrameSize, Reprojection};
use fovol_net::cpu::{Simd, Work};
use rayon::prelude::*;

/// How far away everything could be, one guess after the other. Distances are in world units: the volume's longest side is 1.
#[derive(Debug)]
pub struct Guesses {
    /// Between the samples of this frame.
    near: Filled,
    /// Between these and those of earlier frames.
    seen: Filled,
}

/// What is added to the distances between this frame's samples, guess by guess; the guess after these is of earlier frames too.
pub const OFFSETS: [f32; 5] = [0.0, -0.1, 0.1, -0.2, 0.2];

/// How many guesses there are.
pub const COUNT: usize = OFFSETS.len() + 1;

/// No distance is below this.
pub const NEAREST: f32 = 0.05;

impl Guesses {
    pub fn new(now: Sparse<'_>, earlier: &[(Reprojection, &Depths)]) -> Self {
        let [near, seen] = now.depths.filled_with(earlier, now.frame);
        Self { near, seen }
    }

    pub fn size(&self) -> FrameSize {
        self.near.size()
    }

    /// One over the distance of pixel number `i`, as each guess has it; 0 where nothing is known.
    #[inline(always)]
    pub fn inverses(&self, i: usize) -> [f32; COUNT] {
        let near = self.near.inverse()[i];
        let mut inverses = [self.seen.inverse()[i]; COUNT];
        for (inverse, offset) in inverses.iter_mut().zip(OFFSETS) {
            *inverse = moved_by(near, offset);
        }
        inverses
    }

    /// The motion along the guesses, each as far as `beliefs` believe it.
    pub fn motion(&self, beliefs: &Beliefs, to_last: &Reprojection) -> Vec<[f32; 2]> {
        let width = self.size().width as usize;
        let mut motion = vec![[0.0; 2]; self.size().pixels()];
        motion.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
            for segment in beliefs.row(y, width) {
                let x = segment.pixels.start;
                let row = &mut row[segment.pixels.clone()];
                Simd::best().vectorised(BelievedMotion {
                    guesses: self,
                    segment,
                    to_last,
                    first: [x, y],
                    row,
                });
            }
        });
        motion
    }

    /// One over the distance of pixel number `i`, all guesses taken together.
    #[inline(always)]
    fn believed(&self, belief: Belief, i: usize) -> f32 {
        let (near, seen) = (moved_by(self.near.inverse()[i], belief.offset), self.seen.inverse()[i]);
        if near > 0.0 { near + (seen - near) * belief.seen } else { seen }
    }
}

/// The motion of the pixels of a segment.
struct BelievedMotion<'a> {
    guesses: &'a Guesses,
    segment: Segment,
    to_last: &'a Reprojection,
    first: [usize; 2],
    row: &'a mut [[f32; 2]],
}

impl Work for BelievedMotion<'_> {
    #[inline(always)]
    fn run(self) {
        let Self { guesses, segment, to_last, first, row } = self;
        let from = first[1] * guesses.size().width as usize + first[0];
        put_motion(row, first, to_last, |at| guesses.believed(segment.belief(at), from + at));
    }
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
    motion.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
        put_motion(row, [0, y], reprojection, |x| inverse[y * width + x]);
    });
    motion
}

/// The motion of pixels of a row from `first` on, each one over `inverse` away; none where that is 0.
#[inline(always)]
fn put_motion(
    row: &mut [[f32; 2]],
    first: [usize; 2],
    reprojection: &Reprojection,
    inverse: impl Fn(usize) -> f32,
) {
    let [x, y] = first.map(|c| c as f32);
    for (at, to) in row.iter_mut().enumerate() {
        let inverse = inverse(at);
        let moved = reprojection.motion(x + at as f32, y, inverse);
        *to = if inverse > 0.0 { moved } else { [0.0; 2] };
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
