//! As many rays as there are lanes, on their way side by side.

use super::lanes::{Lanes, MOST_LANES};
use super::segment::Segment;

/// One number per ray.
pub type PerRay = Aligned<[f32; MOST_LANES]>;

/// A value on its own cache line.
#[derive(Debug, Clone, Copy, Default)]
#[repr(align(64))]
pub struct Aligned<T>(pub T);

/// The rays of a packet: where they are and how much light still passes.
///
/// Empty space is left by all rays together, one ray to a lane; samples are taken by one ray at a time,
/// one sample to a lane.
pub struct Packet {
    /// How many rays there are.
    pub len: usize,
    /// First samples, voxel-centre coordinates.
    pub start: [PerRay; 3],
    /// Steps.
    pub delta: [PerRay; 3],
    /// How many samples each ray has.
    pub samples: PerRay,
    /// The number of each ray's next sample.
    pub next: PerRay,
    /// What passes from there to the eye, 0…1.
    pub transmittance: PerRay,
}

impl Packet {
    /// A packet without rays.
    pub fn new() -> Self {
        let zero = PerRay::default();
        Self { len: 0, start: [zero; 3], delta: [zero; 3], samples: zero, next: zero, transmittance: zero }
    }

    /// Removes all rays.
    pub fn clear(&mut self) {
        self.len = 0;
        // Lanes without a ray have no samples.
        self.samples = PerRay::default();
    }

    /// Adds the ray of `segment`.
    ///
    /// # Panics
    /// When there are `MOST_LANES` already.
    #[inline(always)]
    pub fn push(&mut self, segment: &Segment) {
        let lane = self.len;
        for a in 0..3 {
            self.start[a].0[lane] = segment.start[a];
            self.delta[a].0[lane] = segment.delta[a];
        }
        self.samples.0[lane] = segment.count as f32;
        self.next.0[lane] = 0.0;
        self.transmittance.0[lane] = 1.0;
        self.len += 1;
    }

    /// Three coordinates of every ray as vectors.
    ///
    /// # Safety
    /// The instruction set of `L` must be available.
    #[inline(always)]
    pub unsafe fn load<L: Lanes>(of: &[PerRay; 3]) -> [L::F; 3] {
        // SAFETY: the arrays hold at least N elements.
        unsafe { [L::load(of[0].0.as_ptr()), L::load(of[1].0.as_ptr()), L::load(of[2].0.as_ptr())] }
    }
}
