//! Leaving empty space at once.

use super::lanes::Lanes;
use super::macrocells::Macrocells;
use super::segment::{LightPath, SHADOW_STEP, Segment};

/// Stands for "never leaves" along an axis that a ray does not move on.
const NEVER: f32 = 1e30;

/// The macrocells as rays use them: how many samples ahead lies the first that could show anything.
pub struct Skip<'a> {
    cells: &'a Macrocells,
    last: [f32; 3],
    pitch: [i32; 3],
    edge: f32,
    /// 1/Δ towards the light, 0 where it does not move.
    light_inverse: [f32; 3],
    /// 0, or [`NEVER`] where the light does not move.
    light_bias: [f32; 3],
    light_forward: [bool; 3],
}

impl<'a> Skip<'a> {
    /// Skipping by `cells` in a volume of `dims` voxels, and towards `light`.
    pub fn new(cells: &'a Macrocells, dims: [usize; 3], light: &LightPath) -> Self {
        let [nx, ny, _] = cells.cells();
        Self {
            cells,
            last: dims.map(|d| (d - 1) as f32),
            pitch: [1, nx as i32, (nx * ny) as i32],
            edge: (1u32 << cells.shift()) as f32,
            light_inverse: light.inverse.map(|i| if i.is_finite() { i } else { 0.0 }),
            light_bias: light.inverse.map(|i| if i.is_finite() { 0.0 } else { NEVER }),
            light_forward: light.delta.map(|d| d > 0.0),
        }
    }

    /// How many samples from `k` on certainly show nothing; 0 where the next one may.
    #[inline(always)]
    pub fn primary_samples(&self, segment: &Segment, k: u32) -> u32 {
        let p = segment.position(k);
        let shift = self.cells.shift();
        let cell: [i32; 3] = std::array::from_fn(|a| (p[a].clamp(0.0, self.last[a]) as i32) >> shift);
        let at = cell[0] + cell[1] * self.pitch[1] + cell[2] * self.pitch[2];
        let distance = i32::from(self.cells.distances()[at as usize]);
        if distance == 0 {
            return 0;
        }
        let mut ahead = NEVER;
        for a in 0..3 {
            let d = segment.delta[a];
            if d != 0.0 {
                let face = if d > 0.0 { cell[a] + distance } else { cell[a] - distance + 1 };
                ahead = ahead.min((face as f32 * self.edge - p[a]) / d);
            }
        }
        (ahead.ceil() as u32).clamp(1, segment.count - k)
    }

    /// How many shadow samples from `p` on certainly show nothing, per lane; 0 or less where the next one may.
    ///
    /// # Safety
    /// The instruction set of `L` must be available.
    #[inline(always)]
    pub unsafe fn shadow_steps<L: Lanes>(&self, p: [L::F; 3]) -> L::F {
        // SAFETY: positions are clamped to the grid, so every cell exists; distances end in four spare bytes.
        unsafe {
            let zero = L::splat(0.0);
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
                let face = if self.light_forward[a] {
                    L::add(low, distance)
                } else {
                    L::add(L::sub(low, distance), L::splat(1.0))
                };
                let way = L::sub(L::mul(face, L::splat(self.edge)), p[a]);
                ahead =
                    L::min(ahead, L::fma(way, L::splat(self.light_inverse[a]), L::splat(self.light_bias[a])));
            }
            L::max(L::ceil(L::mul(ahead, L::splat(1.0 / SHADOW_STEP))), zero)
        }
    }
}
