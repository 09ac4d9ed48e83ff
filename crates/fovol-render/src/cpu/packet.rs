//! A packet of primary rays that skip empty space side by side, one ray to a lane.

use super::march::OPAQUE;
use crate::scene::{Segment, Segments};
use fovol_core::{Pixel, RayBasis};
use fovol_simd::{MOST_LANES, SimdF32};

/// Rays that are prepared side by side: as many f64 as the widest vectors hold.
const BESIDE: usize = 8;

/// One number per ray.
pub type PerRay = Aligned<[f32; MOST_LANES]>;

/// A value on its own cache line.
#[derive(Debug, Clone, Copy, Default)]
#[repr(align(64))]
pub struct Aligned<T>(pub T);

/// The rays of a packet: where they are and how much light still passes.
///
/// All rays skip empty space together, one ray to a lane. Samples are taken for one ray at a time, one to a lane.
pub struct Packet {
    /// How many rays there are.
    pub len: usize,
    /// The first sample of each ray, in voxel-centre coordinates.
    pub start: [PerRay; 3],
    /// The step Δ of each ray, in voxels.
    pub delta: [PerRay; 3],
    /// 1/Δ along each axis; infinite where a ray does not move on it.
    pub inverse: [PerRay; 3],
    /// How many samples each ray has.
    pub samples: PerRay,
    /// How many steps each ray has through the box.
    pub length: PerRay,
    /// How far the first sample of each ray is from the ray's origin, in world units.
    pub distance: PerRay,
    /// The number of each ray's next sample.
    pub next: PerRay,
    /// Transmittance from each ray's next sample to the eye, 0…1.
    pub transmittance: PerRay,
    /// Each ray's noise, 0…1, where it places few shadow rays.
    pub offset: PerRay,
}

impl Default for Packet {
    fn default() -> Self {
        Self::new()
    }
}

impl Packet {
    /// A packet without rays.
    pub fn new() -> Self {
        let zero = PerRay::default();
        Self {
            len: 0,
            start: [zero; 3],
            delta: [zero; 3],
            inverse: [zero; 3],
            samples: zero,
            length: zero,
            distance: zero,
            next: zero,
            transmittance: zero,
            offset: zero,
        }
    }

    /// Makes this the packet of `pixels`, at most [`MOST_LANES`]; the other lanes have no samples.
    #[inline(always)]
    pub fn fill(&mut self, pixels: &[Pixel], rays: &RayBasis, segments: &Segments) {
        self.len = pixels.len();
        self.next = PerRay::default();
        self.transmittance = Aligned([1.0; MOST_LANES]);
        self.samples = PerRay::default();
        for (part, pixels) in pixels.chunks(BESIDE).enumerate() {
            let (mut x, mut y) = ([0.0; BESIDE], [0.0; BESIDE]);
            for (i, pixel) in pixels.iter().enumerate() {
                (x[i], y[i]) = (f64::from(pixel.x), f64::from(pixel.y));
            }
            let segments = segments.of_many(&rays.beside(&x, &y));
            let lanes = part * BESIDE..(part + 1) * BESIDE;
            for a in 0..3 {
                self.start[a].0[lanes.clone()].copy_from_slice(&segments.start[a]);
                self.delta[a].0[lanes.clone()].copy_from_slice(&segments.delta[a]);
            }
            for a in 0..3 {
                for i in lanes.clone() {
                    self.inverse[a].0[i] = 1.0 / self.delta[a].0[i];
                }
            }
            self.samples.0[lanes.clone()].copy_from_slice(&segments.count);
            self.length.0[lanes.clone()].copy_from_slice(&segments.length);
            self.distance.0[lanes].copy_from_slice(&segments.distance);
        }
        self.samples.0[pixels.len()..].fill(0.0);
        self.length.0[pixels.len()..].fill(0.0);
    }

    /// Makes the ends of steps the samples: one more than steps, where there are any.
    #[inline(always)]
    pub fn count_ends<V: SimdF32>(&mut self, zero: V) {
        let length = zero.load(&self.length.0);
        let ends = length.ceil() + zero.splat(1.0);
        V::select(length.simd_gt(zero), ends, zero).store(&mut self.samples.0);
    }

    /// Whether no ray has any sample.
    #[inline(always)]
    pub fn is_empty(&self) -> bool {
        self.samples.0 == [0.0; MOST_LANES]
    }

    /// The rays that have samples left and are not opaque, one bit each.
    #[inline(always)]
    pub fn going<V: SimdF32>(&self, zero: V) -> u32 {
        let passing = zero.load(&self.transmittance.0).simd_gt(zero.splat(1.0 - OPAQUE));
        let left = zero.load(&self.next.0).simd_lt(zero.load(&self.samples.0));
        V::bits_of(passing & left)
    }

    /// The numbers of the next N samples of the ray in `lane`.
    #[inline(always)]
    pub fn numbers<V: SimdF32>(&self, zero: V, lane: usize) -> V {
        zero.splat(self.next.0[lane]) + zero.iota()
    }

    /// Which of the next N samples of the ray in `lane` there are.
    #[inline(always)]
    pub fn inside<V: SimdF32>(&self, zero: V, lane: usize) -> V::Mask {
        self.numbers(zero, lane).simd_lt(zero.splat(self.samples.0[lane]))
    }

    /// Where the next N samples of the ray in `lane` lie.
    #[inline(always)]
    pub fn next_places<V: SimdF32>(&self, zero: V, lane: usize) -> [V; 3] {
        let number = self.numbers(zero, lane);
        let (delta, start) = (Self::splat(zero, &self.delta, lane), Self::splat(zero, &self.start, lane));
        [
            number.mul_add(delta[0], start[0]),
            number.mul_add(delta[1], start[1]),
            number.mul_add(delta[2], start[2]),
        ]
    }

    /// The samples of the ray in `lane`.
    pub fn segment(&self, lane: usize) -> Segment {
        let of = |of: &[PerRay; 3]| [of[0].0[lane], of[1].0[lane], of[2].0[lane]];
        Segment {
            start: of(&self.start),
            delta: of(&self.delta),
            count: self.samples.0[lane] as u32,
            length: self.length.0[lane],
            distance: self.distance.0[lane],
        }
    }

    /// Three coordinates of the ray in `lane`, each in all lanes of a vector.
    #[inline(always)]
    pub fn splat<V: SimdF32>(zero: V, of: &[PerRay; 3], lane: usize) -> [V; 3] {
        [zero.splat(of[0].0[lane]), zero.splat(of[1].0[lane]), zero.splat(of[2].0[lane])]
    }

    /// Three coordinates of every ray as vectors.
    #[inline(always)]
    pub fn load<V: SimdF32>(zero: V, of: &[PerRay; 3]) -> [V; 3] {
        [zero.load(&of[0].0), zero.load(&of[1].0), zero.load(&of[2].0)]
    }
}
