//! Light at the nodes of rays, found in lanes.

use super::super::field::{Field, Texel};
use super::super::kernel::Lighting;
use super::super::shadow_pool::ShadowPool;
use super::super::shadow_rays::{ByValue, Parts, ShadowRays};
use super::lookup::{Points, entry};
use super::march::{DEEP, NEAR_STEPS};
use crate::scene::{ExtinctionTable, LightPath, SHADOW_STEP};
use fovol_simd::{Simd, SimdF32};

/// The scene that shadow rays cross between nodes and the light.
pub struct ToLight<'a, 'v, T: Texel> {
    /// The volume, scaled to entries of the table.
    pub field: &'a Field<'v, T>,
    /// Extinction and colour between two display values.
    pub extinction: &'a ExtinctionTable,
    /// α of one shadow step.
    pub shadow_alpha: &'a [f32],
    /// The way to the light.
    pub path: &'a LightPath,
    /// How light reaches points.
    pub lighting: &'a Lighting<'v>,
    /// The instruction set of shadow rays.
    pub simd: Simd,
}

impl<T: Texel> ToLight<'_, '_, T> {
    /// Finds the near depth and the far transmittance of every point of `pool`; returns how many samples that took.
    #[inline(always)]
    pub fn find<V: SimdF32>(&self, zero: V, pool: &mut ShadowPool, parts: &mut Parts) -> u64 {
        let mut at = 0;
        while at < pool.len() {
            let p = pool.positions(zero, at);
            let (near, q) = self.near(p, pool.points(zero, at));
            pool.set_near(at, q, near);
            at += V::N;
        }
        let taken = (pool.len() * NEAR_STEPS.len()) as u64;
        match self.lighting {
            Lighting::Full => taken,
            Lighting::Rays(columns, _) => {
                let rays = ShadowRays {
                    absorber: ByValue { field: self.field, alpha: self.shadow_alpha },
                    light: self.path,
                    columns: *columns,
                };
                taken + rays.trace(self.simd, pool, parts)
            }
            Lighting::Cached(grid) => {
                self.read(zero, grid, pool);
                taken
            }
        }
    }

    /// The optical depth of the near part of the shadow rays from `p`, and the points where their far parts begin.
    ///
    /// `front` holds the table entries at `p`. Far parts begin on the face of the box where none is left, or where the
    /// near part already hides the light.
    #[inline(always)]
    fn near<V: SimdF32>(&self, p: [V; 3], mut front: Points<V>) -> (V, [V; 3]) {
        let zero = p[0].splat(0.0);
        let step = zero.splat(SHADOW_STEP);
        let way = self.path.ways_out(p).max(zero);
        let far = ((way - step) * zero.splat(1.0 / SHADOW_STEP)).max(zero);
        let far = V::from_i32(far.to_i32());
        let length = way - step * far;
        let unit = length * zero.splat(self.extinction.unit);
        let (mut near, mut begin) = (zero, 0.0);
        for end in NEAR_STEPS {
            let at = self.towards(p, length * zero.splat(end));
            // SAFETY: fields are scaled to entries of the table.
            let behind = unsafe { self.extinction.points(entry(self.field.sample(at))) };
            let mean = self.extinction.means(&front, &behind, self.field.has_gaps());
            near = (mean * unit).mul_add(zero.splat(end - begin), near);
            (front, begin) = (behind, end);
        }
        let to = V::select(near.simd_gt(zero.splat(DEEP)), way, length);
        (near, self.towards(p, to))
    }

    #[inline(always)]
    fn towards<V: SimdF32>(&self, p: [V; 3], steps: V) -> [V; 3] {
        let [dx, dy, dz] = self.path.delta;
        let (x, y, z) = (steps.splat(dx), steps.splat(dy), steps.splat(dz));
        [steps.mul_add(x, p[0]), steps.mul_add(y, p[1]), steps.mul_add(z, p[2])]
    }

    /// Reads the far transmittance of every point of `pool` from `grid`.
    #[inline(always)]
    fn read<V: SimdF32>(&self, zero: V, grid: &Field<'_, u8>, pool: &mut ShadowPool) {
        let mut at = 0;
        while at < pool.len() {
            let q = pool.positions(zero, at);
            let inside = self.path.ways_out(q).simd_gt(zero.splat(0.5 * SHADOW_STEP));
            let far = V::select(inside, grid.sample(q), zero.splat(1.0));
            pool.set_transmittance(at, far);
            at += V::N;
        }
    }
}
