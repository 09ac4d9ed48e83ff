//! Leaving empty space at once.

use super::lanes::Lanes;
use super::march::OPAQUE;
use super::packet::Packet;
use crate::scene::Macrocells;

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
    ///
    /// # Safety
    /// The instruction set of `L` must be available.
    #[inline(always)]
    pub unsafe fn advance<L: Lanes>(&self, packet: &mut Packet, earlier: f32) -> u32 {
        // SAFETY: the arrays of a packet hold at least N elements.
        unsafe {
            let zero = L::splat(0.0);
            let start = Packet::load::<L>(&packet.start);
            let delta = Packet::load::<L>(&packet.delta);
            let samples = L::load(packet.samples.0.as_ptr());
            let passing = L::gt(L::load(packet.transmittance.0.as_ptr()), L::splat(1.0 - OPAQUE));
            let mut next = L::load(packet.next.0.as_ptr());
            let mut course =
                Course::<L> { inverse: [zero; 3], bias: [zero; 3], forward: [L::gt(zero, zero); 3] };
            for a in 0..3 {
                let inverse = L::load(packet.inverse[a].0.as_ptr());
                let moving = L::lt(L::abs(inverse), L::splat(NEVER));
                course.inverse[a] = L::select(moving, inverse, zero);
                course.bias[a] = L::select(moving, zero, L::splat(NEVER));
                course.forward[a] = L::gt(inverse, zero);
            }
            loop {
                let at = L::sub(next, L::splat(earlier));
                let p = [
                    L::fma(at, delta[0], start[0]),
                    L::fma(at, delta[1], start[1]),
                    L::fma(at, delta[2], start[2]),
                ];
                let ahead = L::max(L::ceil(self.ahead::<L>(p, &course)), zero);
                let jumping = L::and_m(L::and_m(L::gt(ahead, zero), L::lt(next, samples)), passing);
                let bits = L::bits(jumping);
                next = L::select(jumping, L::add(next, ahead), next);
                if 4 * bits.count_ones() <= L::N as u32 {
                    let going = L::bits(L::and_m(L::lt(next, samples), passing));
                    let arrived = going & !bits;
                    if bits == 0 || arrived != 0 {
                        L::store(next, packet.next.0.as_mut_ptr());
                        return arrived;
                    }
                }
            }
        }
    }

    /// The number of steps along `course` from `p` out of the empty box around it; 0 or less in a visible cell.
    #[inline(always)]
    unsafe fn ahead<L: Lanes>(&self, p: [L::F; 3], course: &Course<L>) -> L::F {
        // SAFETY: positions are clamped to the grid, so every cell exists; distances end in four spare bytes.
        unsafe {
            let (zero, one) = (L::splat(0.0), L::splat(1.0));
            let mut cell = [L::splat_i(0); 3];
            let mut at = L::splat_i(0);
            for a in 0..3 {
                let clamped = L::min(L::max(p[a], zero), L::splat(self.last[a]));
                cell[a] = L::shr_by(L::truncate(clamped), self.cells.shift());
                at = L::add_i(at, L::mul_i(cell[a], L::splat_i(self.pitch[a])));
            }
            let words = L::gather::<1>(self.cells.distances().as_ptr(), at);
            let distance = L::to_f32(L::and_i(words, L::splat_i(0xFF)));
            let mut ahead = L::splat(NEVER);
            for a in 0..3 {
                let low = L::to_f32(cell[a]);
                // At distance 0 the face lies behind, and the number of steps comes out at 0 or less.
                let face =
                    L::select(course.forward[a], L::add(low, distance), L::add(L::sub(low, distance), one));
                let way = L::sub(L::mul(face, L::splat(self.edge)), p[a]);
                ahead = L::min(ahead, L::fma(way, course.inverse[a], course.bias[a]));
            }
            // An axis without motion must not hide that the cell shows something.
            L::select(L::gt(distance, zero), ahead, zero)
        }
    }
}

/// Directions, prepared for finding the faces that rays leave boxes through.
struct Course<L: Lanes> {
    /// 1/Δ, 0 where a ray does not move.
    inverse: [L::F; 3],
    /// 0, or [`NEVER`] where a ray does not move.
    bias: [L::F; 3],
    /// Whether coordinates rise.
    forward: [L::M; 3],
}
