//! Isosurfaces in lanes: consecutive samples of one ray side by side, until values cross that of the surface.

use super::super::field::Texel;
use super::super::kernel::Kernel;
use super::super::march::{March, SampleCount};
use super::super::medium::OneVolume;
use super::super::packet::Packet;
use super::march::Crossing;
use crate::scene::{RayResult, SHADOW_START};
use fovol_core::{Pixel, RayBasis};
use fovol_simd::{MOST_LANES, SimdF32};

/// The scene whose surface lanes look for.
pub struct IsosurfaceKernel<'a, T: Texel> {
    pub kernel: Kernel<'a, OneVolume<'a, T>>,
    /// The specification, for the work that is done once a ray.
    pub march: March<'a>,
    /// The display value of the surface.
    pub iso: f32,
}

impl<T: Texel> IsosurfaceKernel<'_, T> {
    /// Marches `pixels` and appends their results to `out`.
    #[inline(always)]
    pub fn march<V: SimdF32>(
        &self,
        zero: V,
        rays: &RayBasis,
        pixels: &[Pixel],
        packet: &mut Packet,
        out: &mut Vec<RayResult>,
    ) -> SampleCount {
        let mut count = SampleCount::default();
        for pixels in pixels.chunks(V::N) {
            packet.fill(pixels, rays, &self.kernel.segments);
            let mut crossings = [None; MOST_LANES];
            loop {
                let mut going = match &self.kernel.skip {
                    Some(skip) => skip.advance(zero, packet, 0.0),
                    None => packet.going(zero),
                };
                if going == 0 {
                    break;
                }
                while going != 0 {
                    let lane = going.trailing_zeros() as usize;
                    going &= going - 1;
                    crossings[lane] = self.block(zero, (packet, lane), &mut count);
                }
            }
            for (lane, crossing) in crossings.iter().take(pixels.len()).enumerate() {
                out.push(match crossing {
                    Some(crossing) => self.surface(zero, (packet, lane), crossing, &mut count),
                    None => RayResult::nothing(self.kernel.background),
                });
            }
        }
        count
    }

    /// Looks at the next samples of ray `lane`, and ends it at a crossing.
    #[inline(always)]
    fn block<V: SimdF32>(
        &self,
        zero: V,
        (packet, lane): (&mut Packet, usize),
        count: &mut SampleCount,
    ) -> Option<Crossing> {
        // A crossing lies between two samples. Of these only the first may be in empty space after a jump, and only the
        // second before one, so that both ends of a block are looked at again.
        let first = (packet.next.0[lane] - 1.0).max(0.0);
        let number = zero.splat(first) + zero.iota();
        packet.next.0[lane] = first + (V::N - 1) as f32;
        let [start, delta] = [&packet.start, &packet.delta].map(|of| Packet::splat(zero, of, lane));
        let p = [
            number.mul_add(delta[0], start[0]),
            number.mul_add(delta[1], start[1]),
            number.mul_add(delta[2], start[2]),
        ];
        let inside = number.simd_lt(zero.splat(packet.samples.0[lane]));
        count.primary += u64::from(V::bits_of(inside).count_ones());
        let Sides { above, below } = self.sides(p, inside);
        let crossings = (above & below >> 1) | (below & above >> 1);
        if crossings == 0 {
            return None;
        }
        let at = crossings.trailing_zeros();
        packet.transmittance.0[lane] = 0.0;
        let is_from_above = above >> at & 1 == 1;
        Some(Crossing { iso: self.iso, before: first + at as f32, is_from_above })
    }

    /// Which of the lanes of `mask` have the value of the surface or more at `p`, and which less.
    #[inline(always)]
    fn sides<V: SimdF32>(&self, p: [V; 3], mask: V::Mask) -> Sides {
        let field = &self.kernel.medium.field;
        let value = field.sample(p);
        let zero = value.splat(0.0);
        let known =
            if field.has_gaps() { mask & value.simd_lt(zero.splat(field.missing - 0.5)) } else { mask };
        let above =
            V::bits_of(known & value.simd_ge(zero.splat(self.iso * self.kernel.medium.table.scale())));
        Sides { above, below: V::bits_of(known) & !above }
    }

    /// The result of the ray in `lane`, which crosses the surface.
    #[inline(always)]
    fn surface<V: SimdF32>(
        &self,
        zero: V,
        (packet, lane): (&Packet, usize),
        crossing: &Crossing,
        count: &mut SampleCount,
    ) -> RayResult {
        let segment = packet.segment(lane);
        let number = self.march.refined(&segment, crossing);
        let is_lit =
            !self.march.casts_mode_shadows() || self.is_lit(zero, segment.at(number), crossing, count);
        self.march.surface_result(&segment, number, (self.iso, is_lit))
    }

    /// Whether everything from `p` to the light is on the side of the surface that the eye is on.
    #[inline(always)]
    fn is_lit<V: SimdF32>(&self, zero: V, p: [f32; 3], crossing: &Crossing, count: &mut SampleCount) -> bool {
        let light = &self.kernel.light;
        let way = light.way_out(p);
        let mut first = SHADOW_START;
        while first < way {
            let steps = zero.splat(first) + zero.iota();
            let at = [
                steps.mul_add(zero.splat(light.delta[0]), zero.splat(p[0])),
                steps.mul_add(zero.splat(light.delta[1]), zero.splat(p[1])),
                steps.mul_add(zero.splat(light.delta[2]), zero.splat(p[2])),
            ];
            let inside = steps.simd_lt(zero.splat(way));
            count.shadow += u64::from(V::bits_of(inside).count_ones());
            let Sides { above, below } = self.sides(at, inside);
            if (if crossing.is_from_above { below } else { above }) != 0 {
                return false;
            }
            first += V::N as f32;
        }
        true
    }
}

/// Lanes by the side of the surface that their value is on, one bit each. Lanes of NaN are on neither.
struct Sides {
    above: u32,
    below: u32,
}
