//! [`LightPath`] for points in lanes.

use crate::scene::{LightPath, SHADOW_START, SHADOW_STEP};
use fovol_simd::SimdF32;

impl LightPath {
    /// [`LightPath::count`] for points in lanes, as whole numbers.
    #[inline(always)]
    pub(super) fn counts<V: SimdF32>(&self, p: [V; 3]) -> V::I32 {
        let zero = p[0].splat(0.0);
        let beyond = self.ways_out(p) - zero.splat(SHADOW_START);
        let count = (beyond * zero.splat(1.0 / SHADOW_STEP)).ceil();
        count.max(zero).to_i32()
    }

    /// [`LightPath::way_out`] for points in lanes.
    #[inline(always)]
    pub(super) fn ways_out<V: SimdF32>(&self, p: [V; 3]) -> V {
        let zero = p[0].splat(0.0);
        let mut distance = zero.splat(f32::INFINITY);
        for a in (0..3).filter(|&a| self.inverse[a].is_finite()) {
            let way = (zero.splat(self.exit[a]) - p[a]) * zero.splat(self.inverse[a]);
            distance = distance.min(way);
        }
        for [x, y, z, w] in self.planes.as_slice() {
            let across = zero.splat(*z).mul_add(p[2], zero.splat(*w));
            let across = zero.splat(*y).mul_add(p[1], across);
            distance = distance.min(zero.splat(*x).mul_add(p[0], across));
        }
        distance
    }
}
