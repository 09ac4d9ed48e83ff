use super::depth_confidence::{Beliefs, DepthConfidence};
use super::depth_hypotheses::{DepthHypotheses, moved_by, put_motion};
use fovol_core::Reprojection;
use fovol_simd::{Simd, SimdOp};
use rayon::prelude::*;

/// Motion of every pixel to the last frame, from the guesses weighed by `beliefs`. In pixels, x right and y down.
pub fn weighed_motion(guesses: &DepthHypotheses, beliefs: &Beliefs, to_last: &Reprojection) -> Vec<[f32; 2]> {
    let width = guesses.size().width as usize;
    let mut motion = vec![[0.0; 2]; guesses.size().pixels()];
    let rows = motion.par_chunks_mut(width).enumerate();
    rows.for_each_init(Memory::default, |memory, (y, row)| {
        let motion = MotionOfRow { guesses, beliefs, to_last, y, memory, row };
        Simd::best().vectorised(motion);
    });
    motion
}

/// Buffers for one row.
#[derive(Default)]
struct Memory {
    near: Vec<f32>,
    seen: Vec<f32>,
    line: Vec<f32>,
}

/// SIMD operation that finds the motion of one row of pixels.
struct MotionOfRow<'a> {
    guesses: &'a DepthHypotheses,
    beliefs: &'a Beliefs,
    to_last: &'a Reprojection,
    y: usize,
    memory: &'a mut Memory,
    row: &'a mut [[f32; 2]],
}

impl SimdOp for MotionOfRow<'_> {
    type Output = ();

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

/// Inverse distance from the guesses `near` (this frame) and `seen` (earlier frames too), weighed by `belief`.
#[inline(always)]
fn believed(belief: DepthConfidence, near: f32, seen: f32) -> f32 {
    let near = moved_by(near, belief.offset);
    if near > 0.0 { near + (seen - near) * belief.seen } else { seen }
}
