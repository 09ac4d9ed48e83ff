//! Greatest, least and mean values along rays, in lanes.

use super::super::field::Texel;
use super::super::kernel::Kernel;
use super::super::march::SampleCount;
use super::super::medium::OneVolume;
use super::super::packet::{Aligned, Packet, PerRay};
use super::projected::projected;
use crate::scene::RayResult;
use fovol_core::{Pixel, RayBasis, RayMode, TransferFunction};
use fovol_simd::{MOST_LANES, SimdF32};

/// Which value of a ray is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Projection {
    Greatest,
    Least,
    Mean,
}

impl Projection {
    /// The projection of `mode`, if it is one.
    pub fn of(mode: RayMode) -> Option<Self> {
        match mode {
            RayMode::Mip => Some(Self::Greatest),
            RayMode::Minip => Some(Self::Least),
            RayMode::Average => Some(Self::Mean),
            RayMode::Composite | RayMode::Isosurface(_) => None,
        }
    }
}

/// The scene whose values lanes project.
pub struct ProjectionKernel<'a, T: Texel> {
    pub kernel: Kernel<'a, OneVolume<'a, T>>,
    pub transfer: &'a TransferFunction,
    pub projection: Projection,
}

/// Values of a ray that were found so far, one number per lane.
#[derive(Clone, Copy)]
struct Found {
    /// The greatest or least values, or sums of values.
    values: PerRay,
    /// Numbers of their samples, or sums of numbers.
    numbers: PerRay,
    /// How many samples were numbers.
    known: PerRay,
}

impl<T: Texel> ProjectionKernel<'_, T> {
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
        let first = match self.projection {
            Projection::Greatest => f32::NEG_INFINITY,
            Projection::Least => f32::INFINITY,
            Projection::Mean => 0.0,
        };
        for pixels in pixels.chunks(V::N) {
            packet.fill(pixels, rays, &self.kernel.segments);
            let nothing = Found {
                values: Aligned([first; MOST_LANES]),
                numbers: PerRay::default(),
                known: PerRay::default(),
            };
            let mut found = [nothing; MOST_LANES];
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
                    count.primary += self.block(zero, (packet, lane), &mut found[lane]);
                }
            }
            // Closures would be compiled without the instruction set.
            for (lane, found) in found.iter().take(pixels.len()).enumerate() {
                out.push(self.result(packet, lane, found));
            }
        }
        count
    }

    /// Looks at the next N samples of ray `lane`; returns how many of them there were.
    #[inline(always)]
    fn block<V: SimdF32>(&self, zero: V, (packet, lane): (&mut Packet, usize), found: &mut Found) -> u64 {
        let number = zero.splat(packet.next.0[lane]) + zero.iota();
        packet.next.0[lane] += V::N as f32;
        let [start, delta] = [&packet.start, &packet.delta].map(|of| Packet::splat(zero, of, lane));
        let p = [
            number.mul_add(delta[0], start[0]),
            number.mul_add(delta[1], start[1]),
            number.mul_add(delta[2], start[2]),
        ];
        let field = &self.kernel.medium.field;
        let value = field.sample(p);
        let inside = number.simd_lt(zero.splat(packet.samples.0[lane]));
        let known =
            if field.has_gaps() { inside & value.simd_lt(zero.splat(field.missing - 0.5)) } else { inside };
        let (values, numbers) = (zero.load(&found.values.0), zero.load(&found.numbers.0));
        let (values, numbers) = match self.projection {
            Projection::Greatest => {
                let better = known & value.simd_gt(values);
                (V::select(better, value, values), V::select(better, number, numbers))
            }
            Projection::Least => {
                let better = known & value.simd_lt(values);
                (V::select(better, value, values), V::select(better, number, numbers))
            }
            Projection::Mean => {
                (values + V::select(known, value, zero), numbers + V::select(known, number, zero))
            }
        };
        values.store(&mut found.values.0);
        numbers.store(&mut found.numbers.0);
        let known = V::select(known, zero.splat(1.0), zero);
        (zero.load(&found.known.0) + known).store(&mut found.known.0);
        u64::from(V::bits_of(inside).count_ones())
    }

    /// The result of the ray in `lane`.
    fn result(&self, packet: &Packet, lane: usize, found: &Found) -> RayResult {
        let kernel = &self.kernel;
        let known: f32 = found.known.0.iter().sum();
        // Skipped space shows nothing, nor does a ray that met nothing else.
        if packet.samples.0[lane] == 0.0 || (known == 0.0 && !kernel.medium.field.has_gaps()) {
            return RayResult::nothing(kernel.background);
        }
        let (value, number) = match self.projection {
            _ if known == 0.0 => (f32::NAN, 0.0),
            Projection::Mean => {
                (found.values.0.iter().sum::<f32>() / known, found.numbers.0.iter().sum::<f32>() / known)
            }
            Projection::Greatest | Projection::Least => found.best(self.projection),
        };
        let depth = kernel.segments.distance(packet.distance.0[lane], number);
        let value = f64::from(value) / f64::from(kernel.medium.table.scale());
        projected(self.transfer, kernel.background, value, depth)
    }
}

impl Found {
    /// The best value of all lanes, and the number of the first sample that has it.
    fn best(&self, projection: Projection) -> (f32, f32) {
        let mut best = (self.values.0[0], self.numbers.0[0]);
        for (&value, &number) in self.values.0.iter().zip(&self.numbers.0).skip(1) {
            let is_better = match projection {
                Projection::Least => value < best.0,
                _ => value > best.0,
            };
            if is_better || (value == best.0 && number < best.1) {
                best = (value, number);
            }
        }
        best
    }
}
