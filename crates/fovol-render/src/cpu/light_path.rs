//! [`LightPath`] for points in lanes.

use super::lanes::Lanes;
use crate::scene::{LightPath, SHADOW_START, SHADOW_STEP};

impl LightPath {
    /// [`LightPath::count`] for points in lanes, as whole numbers.
    ///
    /// # Safety
    /// The instruction set of `L` must be available.
    #[inline(always)]
    pub(super) unsafe fn counts<L: Lanes>(&self, p: [L::F; 3]) -> L::I {
        // SAFETY: the caller's.
        unsafe {
            let beyond = L::sub(self.ways_out::<L>(p), L::splat(SHADOW_START));
            let count = L::ceil(L::mul(beyond, L::splat(1.0 / SHADOW_STEP)));
            L::truncate(L::max(count, L::splat(0.0)))
        }
    }

    /// [`LightPath::way_out`] for points in lanes.
    ///
    /// # Safety
    /// The instruction set of `L` must be available.
    #[inline(always)]
    pub(super) unsafe fn ways_out<L: Lanes>(&self, p: [L::F; 3]) -> L::F {
        // SAFETY: the caller's.
        unsafe {
            let mut distance = L::splat(f32::INFINITY);
            for a in (0..3).filter(|&a| self.inverse[a].is_finite()) {
                let way = L::mul(L::sub(L::splat(self.exit[a]), p[a]), L::splat(self.inverse[a]));
                distance = L::min(distance, way);
            }
            distance
        }
    }
}
