//! Stretches of rays that wait for the light at their ends.

use super::super::lanes::{Lanes, MOST_LANES};
use super::super::shadow_pool::ShadowPool;
use super::exponential::{mean_passing, passing};
use super::march::DEEP;

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
    ///
    /// # Safety
    /// The instruction set of `L` must be available.
    #[inline(always)]
    pub unsafe fn push<L: Lanes>(
        &mut self,
        begins: u32,
        values: [L::F; 4],
        (nodes, from): (u32, usize),
        ray: usize,
    ) {
        let len = self.nodes.len();
        if self.columns[0].len() < len + MOST_LANES {
            let size = (len + MOST_LANES).next_power_of_two();
            self.columns.iter_mut().for_each(|column| column.resize(size, 0.0));
        }
        for (column, v) in self.columns.iter_mut().zip(values) {
            // SAFETY: there is a vector's room after `len`.
            unsafe { L::compress(v, L::mask(begins), column.as_mut_ptr().add(len)) };
        }
        let mut left = begins;
        while left != 0 {
            let before = nodes & ((1 << left.trailing_zeros()) - 1);
            left &= left - 1;
            self.nodes.push(from as u32 + before.count_ones());
            self.rays.push(ray as u32);
        }
    }

    /// Calls `add` with every ray and the light that comes from one of its stretches to the eye, as found in `pool`.
    ///
    /// # Safety
    /// The instruction set of `L` must be available, and `pool` must hold the nodes.
    #[inline(always)]
    pub unsafe fn arrive<L: Lanes>(&mut self, pool: &ShadowPool, mut add: impl FnMut(usize, [f32; 3])) {
        let len = self.nodes.len();
        // Whole vectors are read below.
        self.nodes.resize(len + MOST_LANES, 0);
        for at in (0..len).step_by(L::N) {
            // SAFETY: there is a vector's room after the last; unused lanes read the first nodes.
            let light = unsafe {
                let node = L::to_bits(L::load(self.nodes.as_ptr().add(at).cast()));
                let [r, g, b, depth] = [0, 1, 2, 3].map(|c| L::load(self.columns[c].as_ptr().add(at)));
                let arriving = Self::arriving::<L>(depth, pool.lights::<L>(node));
                [r, g, b].map(|v| {
                    let mut lanes = [0.0; MOST_LANES];
                    L::store(L::mul(v, arriving), lanes.as_mut_ptr());
                    lanes
                })
            };
            for lane in 0..L::N.min(len - at) {
                add(self.rays[at + lane] as usize, light.map(|lanes| lanes[lane]));
            }
        }
        self.nodes.truncate(len);
    }

    /// The mean share of light on stretches of optical `depth`, weighted by transmittance to the eye.
    ///
    /// `near` and `far` are the near depths and the far transmittances at both ends.
    #[inline(always)]
    unsafe fn arriving<L: Lanes>(depth: L::F, [near, far]: [[L::F; 2]; 2]) -> L::F {
        // SAFETY: the caller's.
        unsafe {
            let deep = near.map(|depth| L::gt(depth, L::splat(DEEP)));
            let mean = L::mul(L::splat(0.5), L::add(far[0], far[1]));
            let seen = L::select(deep[0], far[1], L::select(deep[1], far[0], mean));
            let rising = L::add(depth, L::sub(near[1], near[0]));
            let share = L::div(mean_passing::<L>(rising), mean_passing::<L>(depth));
            L::mul(L::mul(share, passing::<L>(near[0])), seen)
        }
    }
}
