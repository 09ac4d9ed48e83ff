//! Light at the nodes of rays, found in lanes.

use super::super::field::{Field, Texel};
use super::super::kernel::Lighting;
use super::super::lanes::Lanes;
use super::super::shadow_pool::ShadowPool;
use super::super::shadow_rays::{Parts, ShadowRays, trace};
use super::lookup::{Points, entry};
use super::march::{DEEP, NEAR_STEPS};
use crate::scene::{ExtinctionTable, LightPath, SHADOW_STEP};

/// The scene that shadow rays cross between nodes and the light.
pub struct ToLight<'a, T> {
    /// The volume, scaled to entries of the table.
    pub field: &'a Field<'a, T>,
    /// Extinction and colour between two display values.
    pub extinction: &'a ExtinctionTable,
    /// α of one shadow step.
    pub shadow_alpha: &'a [f32],
    /// The way to the light.
    pub path: &'a LightPath,
    /// How light reaches points.
    pub lighting: &'a Lighting<'a>,
}

impl<T: Texel> ToLight<'_, T> {
    /// Finds the near depth and the far transmittance of every point of `pool`; returns how many samples that took.
    ///
    /// # Safety
    /// The instruction set of `L` must be available.
    #[inline(always)]
    pub unsafe fn find<L: Lanes>(&self, pool: &mut ShadowPool, parts: &mut Parts) -> u64 {
        // SAFETY: the caller's.
        unsafe {
            let mut at = 0;
            while at < pool.len() {
                let p = pool.positions::<L>(at);
                let (near, q) = self.near::<L>(p, pool.points::<L>(at));
                pool.set_near::<L>(at, q, near);
                at += L::N;
            }
            let taken = (pool.len() * NEAR_STEPS.len()) as u64;
            match self.lighting {
                Lighting::Full => taken,
                Lighting::Rays(columns) => {
                    let rays = ShadowRays {
                        field: self.field,
                        alpha: self.shadow_alpha,
                        light: self.path,
                        columns: *columns,
                    };
                    taken + trace::<L, T>(&rays, pool, parts)
                }
                Lighting::Cached(grid) => {
                    self.read::<L>(grid, pool);
                    taken
                }
            }
        }
    }

    /// The optical depth of the near part of the shadow rays from `p`, and the points where their far parts begin.
    ///
    /// `front` holds the table entries at `p`. Far parts begin on the face of the box where none is left, or where the
    /// near part already hides the light.
    #[inline(always)]
    unsafe fn near<L: Lanes>(&self, p: [L::F; 3], mut front: Points<L>) -> (L::F, [L::F; 3]) {
        // SAFETY: entries come from display values in 0…1 scaled to the table.
        unsafe {
            let (zero, step) = (L::splat(0.0), L::splat(SHADOW_STEP));
            let way = L::max(self.path.ways_out::<L>(p), zero);
            let far = L::max(L::mul(L::sub(way, step), L::splat(1.0 / SHADOW_STEP)), zero);
            let far = L::to_f32(L::truncate(far));
            let length = L::sub(way, L::mul(step, far));
            let unit = L::mul(length, L::splat(self.extinction.unit));
            let (mut near, mut begin) = (zero, 0.0);
            for end in NEAR_STEPS {
                let at = self.towards::<L>(p, L::mul(length, L::splat(end)));
                let behind = self.extinction.points::<L>(entry::<L>(self.field.sample::<L>(at)));
                let mean = self.extinction.means::<L, T>(&front, &behind);
                near = L::fma(L::mul(mean, unit), L::splat(end - begin), near);
                (front, begin) = (behind, end);
            }
            let to = L::select(L::gt(near, L::splat(DEEP)), way, length);
            (near, self.towards::<L>(p, to))
        }
    }

    #[inline(always)]
    unsafe fn towards<L: Lanes>(&self, p: [L::F; 3], steps: L::F) -> [L::F; 3] {
        let delta = self.path.delta;
        // SAFETY: the caller's.
        unsafe {
            [
                L::fma(steps, L::splat(delta[0]), p[0]),
                L::fma(steps, L::splat(delta[1]), p[1]),
                L::fma(steps, L::splat(delta[2]), p[2]),
            ]
        }
    }

    /// Reads the far transmittance of every point of `pool` from `grid`.
    #[inline(always)]
    unsafe fn read<L: Lanes>(&self, grid: &Field<'_, u8>, pool: &mut ShadowPool) {
        // SAFETY: the caller's.
        unsafe {
            let mut at = 0;
            while at < pool.len() {
                let q = pool.positions::<L>(at);
                let inside = L::gt(self.path.ways_out::<L>(q), L::splat(0.5 * SHADOW_STEP));
                let half = L::splat(0.5);
                let on_grid = [
                    L::mul(L::sub(q[0], half), half),
                    L::mul(L::sub(q[1], half), half),
                    L::mul(L::sub(q[2], half), half),
                ];
                let far = L::select(inside, grid.sample::<L>(on_grid), L::splat(1.0));
                pool.set_transmittance::<L>(at, far);
                at += L::N;
            }
        }
    }
}
