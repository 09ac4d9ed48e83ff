//! Stretches of rays that wait for the light at their ends.

use super::super::few_shadow_rays::Chosen;
use super::super::shadow_pool::ShadowPool;
use super::exponential::{mean_passing, passing};
use super::march::DEEP;
use bytemuck::cast_slice;
use fovol_simd::{MOST_LANES, SimdF32};

/// Stretches of rays that wait for their light.
///
/// A stretch lies between two neighbouring nodes of a ray. It is two steps long, or four where optical depth is low.
#[derive(Default)]
pub struct Stretches {
    /// Red, green and blue that each stretch would add in full light, and its optical depth.
    columns: [Vec<f32>; 4],
    /// For each stretch, the pool index of the node in front; the node behind follows it.
    nodes: Vec<u32>,
    /// For each stretch, its ray.
    rays: Vec<u32>,
}

impl Stretches {
    /// Forgets all, keeps the memory.
    pub fn clear(&mut self) {
        self.nodes.clear();
        self.rays.clear();
    }

    /// Appends the stretches of `ray` that begin at the lanes `begins`.
    ///
    /// These lanes hold their `values`. The first of the `nodes` (a bit each) is at `from` in the pool.
    #[inline(always)]
    pub fn push<V: SimdF32>(&mut self, begins: u32, values: [V; 4], (nodes, from): (u32, usize), ray: usize) {
        let len = self.nodes.len();
        if self.columns[0].len() < len + MOST_LANES {
            let size = (len + MOST_LANES).next_power_of_two();
            self.columns.iter_mut().for_each(|column| column.resize(size, 0.0));
        }
        for (column, v) in self.columns.iter_mut().zip(values) {
            v.compress(v.mask_of(begins), &mut column[len..]);
        }
        let mut left = begins;
        while left != 0 {
            let before = nodes & ((1 << left.trailing_zeros()) - 1);
            left &= left - 1;
            self.nodes.push(from as u32 + before.count_ones());
            self.rays.push(ray as u32);
        }
    }

    /// Number of stretches.
    pub fn len(&self) -> usize {
        self.nodes.len()
    }

    /// Red, green and blue of all stretches in full light, and room beyond them.
    #[inline(always)]
    pub fn colours(&self) -> [&[f32]; 3] {
        let [r, g, b, _] = &self.columns;
        [r, g, b]
    }

    /// Keeps only the stretches of `chosen`, with their weights, and the nodes of `pool` that they need.
    pub fn keep(&mut self, chosen: &[Chosen], pool: &mut ShadowPool, kept: &mut ShadowPool) {
        kept.clear();
        kept.reserve(2 * chosen.len());
        // Chosen stretches are in the order of blocks, so none is overwritten before it has been read.
        for (at, chosen) in chosen.iter().enumerate() {
            let node = self.nodes[chosen.place] as usize;
            self.columns[..3].iter_mut().for_each(|column| column[at] = column[chosen.place] * chosen.weight);
            self.columns[3][at] = self.columns[3][chosen.place];
            (self.nodes[at], self.rays[at]) = (kept.len() as u32, chosen.ray as u32);
            (0..2).for_each(|end| kept.push_copy(pool, node + end));
        }
        self.nodes.truncate(chosen.len());
        self.rays.truncate(chosen.len());
        std::mem::swap(pool, kept);
    }

    /// Calls `add` with every ray and the light of one of its stretches that shadows take away, as found in `pool`.
    #[inline(always)]
    pub fn shadow<V: SimdF32>(&mut self, zero: V, pool: &ShadowPool, mut add: impl FnMut(usize, [f32; 3])) {
        let len = self.nodes.len();
        // Whole vectors are read below.
        self.nodes.resize(len + MOST_LANES, 0);
        for at in (0..len).step_by(V::N) {
            let node = zero.load(cast_slice(&self.nodes[at..])).to_bits();
            let [r, g, b, depth] = &self.columns;
            // SAFETY: nodes are those of the pool; unused lanes read the first.
            let lights = unsafe { pool.lights(node) };
            let dark = Self::arriving(zero.load(&depth[at..]), lights) - zero.splat(1.0);
            let mut shadow = [[0.0; MOST_LANES]; 3];
            (zero.load(&r[at..]) * dark).store(&mut shadow[0]);
            (zero.load(&g[at..]) * dark).store(&mut shadow[1]);
            (zero.load(&b[at..]) * dark).store(&mut shadow[2]);
            for lane in 0..V::N.min(len - at) {
                add(self.rays[at + lane] as usize, [shadow[0][lane], shadow[1][lane], shadow[2][lane]]);
            }
        }
        self.nodes.truncate(len);
    }

    /// The mean share of light on stretches of optical `depth`, weighted by transmittance to the eye.
    ///
    /// `near` and `far` are the near depths and the far transmittances at both ends.
    #[inline(always)]
    fn arriving<V: SimdF32>(depth: V, [near, far]: [[V; 2]; 2]) -> V {
        let most = depth.splat(DEEP);
        let deep = [near[0].simd_gt(most), near[1].simd_gt(most)];
        let mean = depth.splat(0.5) * (far[0] + far[1]);
        let seen = V::select(deep[0], far[1], V::select(deep[1], far[0], mean));
        let rising = depth + (near[1] - near[0]);
        let share = mean_passing(rising) / mean_passing(depth);
        share * passing(near[0]) * seen
    }
}
