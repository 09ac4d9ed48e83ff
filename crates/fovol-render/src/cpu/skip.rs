//! Leaving empty space at once.

use super::march::OPAQUE;
use super::packet::Packet;
use crate::scene::Macrocells;
use fovol_simd::{SimdF32, SimdI32};

/// Stands for "never leaves" along an axis that a ray does not move on.
const NEVER: f32 = 1e30;

/// The macrocells as rays use them: how many samples ahead lies the first that could show anything.
pub struct Skip<'a> {
    cells: &'a Macrocells,
    last: [f32; 3],
    pitch: [i32; 3],
    edge: f32,
}

impl<'a> Skip<'a> {
    /// Skipping by `cells` in a volume of `dims` voxels.
    pub fn new(cells: &'a Macrocells, dims: [usize; 3]) -> Self {
        let [nx, ny, _] = cells.cells();
        Self {
            cells,
            last: dims.map(|d| (d - 1) as f32),
            pitch: [1, nx as i32, (nx * ny) as i32],
            edge: (1u32 << cells.shift()) as f32,
        }
    }

    /// Advances the rays of `packet` to their next sample in visible space, or past their last; returns a bit for each
    /// ray that arrived at such a sample.
    ///
    /// A few rays may still be skipping; the others do not wait for them. Samples lie `earlier` by this fraction of a
    /// step: at ½ they are the ends of steps.
    #[inline(always)]
    pub fn advance<V: SimdF32>(&self, zero: V, packet: &mut Packet, earlier: f32) -> u32 {
        let start = Packet::load(zero, &packet.start);
        let delta = Packet::load(zero, &packet.delta);
        let samples = zero.load(&packet.samples.0);
        let passing = zero.load(&packet.transmittance.0).simd_gt(zero.splat(1.0 - OPAQUE));
        let mut next = zero.load(&packet.next.0);
        let mut course = Course { inverse: [zero; 3], bias: [zero; 3], forward: [zero.simd_gt(zero); 3] };
        for a in 0..3 {
            let inverse = zero.load(&packet.inverse[a].0);
            let moving = inverse.abs().simd_lt(zero.splat(NEVER));
            course.inverse[a] = V::select(moving, inverse, zero);
            course.bias[a] = V::select(moving, zero, zero.splat(NEVER));
            course.forward[a] = inverse.simd_gt(zero);
        }
        loop {
            let at = next - zero.splat(earlier);
            let p = [
                at.mul_add(delta[0], start[0]),
                at.mul_add(delta[1], start[1]),
                at.mul_add(delta[2], start[2]),
            ];
            let ahead = self.ahead(p, &course).ceil().max(zero);
            let jumping = ahead.simd_gt(zero) & next.simd_lt(samples) & passing;
            let bits = V::bits_of(jumping);
            next = V::select(jumping, next + ahead, next);
            if 4 * bits.count_ones() <= V::N as u32 {
                let going = V::bits_of(next.simd_lt(samples) & passing);
                let arrived = going & !bits;
                if bits == 0 || arrived != 0 {
                    next.store(&mut packet.next.0);
                    return arrived;
                }
            }
        }
    }

    /// The number of steps along `course` from `p` out of the empty box around it; 0 or less in a visible cell.
    #[inline(always)]
    fn ahead<V: SimdF32>(&self, p: [V; 3], course: &Course<V>) -> V {
        let zero = p[0].splat(0.0);
        let one = zero.splat(1.0);
        let mut cell = [zero.splat_i32(0); 3];
        let mut at = zero.splat_i32(0);
        for a in 0..3 {
            let clamped = p[a].max(zero).min(zero.splat(self.last[a]));
            cell[a] = clamped.to_i32().shr_by(self.cells.shift());
            at = at + cell[a] * zero.splat_i32(self.pitch[a]);
        }
        // SAFETY: positions are clamped to the grid, so every cell exists; distances end in four spare bytes.
        let words = unsafe { V::gather_bytes::<1>(self.cells.distances(), at) };
        let distance = V::from_i32(words & zero.splat_i32(0xFF));
        let mut ahead = zero.splat(NEVER);
        for a in 0..3 {
            let low = V::from_i32(cell[a]);
            // At distance 0 the face lies behind, and the number of steps comes out at 0 or less.
            let face = V::select(course.forward[a], low + distance, low - distance + one);
            let way = face * zero.splat(self.edge) - p[a];
            ahead = ahead.min(way.mul_add(course.inverse[a], course.bias[a]));
        }
        // An axis without motion must not hide that the cell shows something.
        V::select(distance.simd_gt(zero), ahead, zero)
    }
}

/// Directions, prepared for finding the faces that rays leave boxes through.
struct Course<V: SimdF32> {
    /// 1/Δ, 0 where a ray does not move.
    inverse: [V; 3],
    /// 0, or [`NEVER`] where a ray does not move.
    bias: [V; 3],
    /// Whether coordinates rise.
    forward: [V::Mask; 3],
}
