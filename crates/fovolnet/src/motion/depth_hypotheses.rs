use super::depths::Depths;
use fovol_core::{FrameSize, Reprojection};
use fovol_net::FilledNumbers;
use rayon::prelude::*;

/// Depth hypotheses (guesses) of every pixel. Distances are in world units: the volume's longest side is 1.
#[derive(Debug)]
pub struct DepthHypotheses {
    /// Inverse distances interpolated from the samples of this frame, and from these together with those of earlier
    /// frames.
    pub(super) filled: FilledNumbers,
}

/// Offsets added to the distances interpolated from this frame's samples, one guess each. One more guess follows, which
/// also uses earlier frames.
pub const OFFSETS: [f32; 5] = [0.0, -0.1, 0.1, -0.2, 0.2];

/// Number of guesses.
pub const COUNT: usize = OFFSETS.len() + 1;

/// Smallest distance of a guess with an offset.
pub const NEAREST: f32 = 0.05;

impl DepthHypotheses {
    pub fn new(now: &Depths, earlier: &[(Reprojection, &Depths)]) -> Self {
        Self { filled: now.filled_with(earlier) }
    }

    pub fn size(&self) -> FrameSize {
        self.filled.size()
    }

    /// Inverse distances at `pixel`: from the samples of this frame, and from these together with those of earlier
    /// frames. 0 if unknown.
    #[inline(always)]
    pub fn inverses(&self, pixel: [usize; 2]) -> [f32; 2] {
        self.filled.at(pixel)
    }
}

/// Inverse distance of guess number `guess`, from the two values of [`DepthHypotheses::inverses`].
#[inline(always)]
pub fn guessed(guess: usize, near: f32, seen: f32) -> f32 {
    OFFSETS.get(guess).map_or(seen, |offset| moved_by(near, *offset))
}

/// Inverse of the distance 1/`inverse` + `offset`.
#[inline(always)]
pub fn moved_by(inverse: f32, offset: f32) -> f32 {
    if inverse > 0.0 && offset != 0.0 { 1.0 / (1.0 / inverse + offset).max(NEAREST) } else { inverse }
}

/// Motion of all pixels of a frame of `size` from their inverse distances.
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

/// Writes the motion of row `y` from the inverse distances of its pixels; no motion where that is 0.
#[inline(always)]
pub fn put_motion(row: &mut [[f32; 2]], y: usize, reprojection: &Reprojection, inverse: &[f32]) {
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
