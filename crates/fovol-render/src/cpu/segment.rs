use fovol_core::{Grid, Light, Ray};
use glam::DVec3;

/// A grid and a step, prepared to make [`Segment`]s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Segments {
    /// Half the extent of the box, world units.
    half: DVec3,
    /// Δ in world units.
    delta: f64,
    /// From world units to voxels.
    to_voxels: DVec3,
}

impl Segments {
    /// Segments of rays through `grid` at distances of `step` voxels (of the smallest spacing).
    pub fn new(grid: &Grid, step: f64) -> Self {
        Self {
            half: grid.world_extent() * 0.5,
            delta: step * grid.smallest_voxel(),
            to_voxels: grid.voxel_size().recip(),
        }
    }

    /// The samples of `ray`.
    #[inline(always)]
    pub fn of(&self, ray: &Ray) -> Segment {
        let Some((near, far)) = ray.clip_to(self.half) else { return Segment::EMPTY };
        // Samples k with k + ½ < (far − near)/Δ: ⌈x⌉ as ⌊x⌋ plus one where something is left over.
        let length = (far - near) / self.delta - 0.5;
        let whole = length.max(0.0) as u32;
        let count = whole + u32::from(length > f64::from(whole));
        let first = ray.origin + ray.direction * (near + 0.5 * self.delta);
        let start = (first + self.half) * self.to_voxels - DVec3::splat(0.5);
        let delta = ray.direction * self.delta * self.to_voxels;
        Segment { start: start.as_vec3().to_array(), delta: delta.as_vec3().to_array(), count }
    }
}

/// The samples of one primary ray in voxel-centre coordinates (voxel *i* at *i*): sample *k* lies at
/// `start + k·delta`, k = 0…`count` − 1.
///
/// Samples are at t_near + (k+½)·Δ while t < t_far.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Segment {
    /// The first sample.
    pub start: [f32; 3],
    /// From one sample to the next.
    pub delta: [f32; 3],
    /// How many samples there are.
    pub count: u32,
}

impl Segment {
    /// A ray that misses the box.
    pub const EMPTY: Self = Self { start: [0.0; 3], delta: [0.0; 3], count: 0 };

    /// Where sample `k` lies.
    #[inline(always)]
    pub fn position(&self, k: u32) -> [f32; 3] {
        std::array::from_fn(|a| (k as f32).mul_add(self.delta[a], self.start[a]))
    }
}

/// The way to the light, the same for every sample.
///
/// A shadow ray takes steps of 4Δ, the first sample 2Δ from its point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LightPath {
    /// Δ along the light direction, in voxels.
    pub delta: [f32; 3],
    /// The faces of the box that the light comes through, in voxel-centre coordinates.
    pub exit: [f32; 3],
    /// 1/delta; infinite where the light is parallel to a face.
    pub inverse: [f32; 3],
}

/// Shadow steps are this many primary steps long (ALGORITHMS: the paper's quarter rate).
pub const SHADOW_STEP: f32 = 4.0;
/// The first shadow sample is this many primary steps from its point.
pub const SHADOW_START: f32 = 2.0;

impl LightPath {
    /// The way from any point of `grid` towards `light` at primary steps of `step` voxels.
    pub fn new(light: &Light, grid: &Grid, step: f64) -> Self {
        let delta =
            (light.direction() * (step * grid.smallest_voxel()) / grid.voxel_size()).as_vec3().to_array();
        let dims = grid.dims();
        let exit = std::array::from_fn(|a| if delta[a] > 0.0 { dims[a] as f32 - 0.5 } else { -0.5 });
        // A vanishing component never leaves: a huge inverse of either sign would, so make it plainly infinite.
        let inverse = delta.map(|d| if d.abs() < 1e-20 { f32::INFINITY } else { 1.0 / d });
        Self { delta, exit, inverse }
    }

    /// How many shadow samples lie between `p` (voxel-centre coordinates) and the box.
    #[inline]
    pub fn count(&self, p: [f32; 3]) -> u32 {
        let mut distance = f32::INFINITY;
        for a in 0..3 {
            if self.inverse[a].is_finite() {
                distance = distance.min((self.exit[a] - p[a]) * self.inverse[a]);
            }
        }
        // 2 + 4j < distance
        ((distance - SHADOW_START) / SHADOW_STEP).ceil() as u32
    }

    /// Where shadow sample `j` of point `p` lies.
    #[inline(always)]
    pub fn position(&self, p: [f32; 3], j: u32) -> [f32; 3] {
        let steps = SHADOW_STEP.mul_add(j as f32, SHADOW_START);
        std::array::from_fn(|a| steps.mul_add(self.delta[a], p[a]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_are_half_a_step_in_and_stop_before_the_far_face() {
        let grid = Grid::new([10, 10, 10], [1.0; 3]).unwrap();
        let ray = Ray { origin: DVec3::new(-2.0, 0.0, 0.0), direction: DVec3::X };
        let segment = Segments::new(&grid, 0.5).of(&ray);
        assert_eq!(segment.count, 20);
        assert!((segment.position(0)[0] - (0.25 - 0.5)).abs() < 1e-5);
        assert!((segment.position(19)[0] - (9.75 - 0.5)).abs() < 1e-5);
    }

    #[test]
    fn shadow_samples_stop_before_the_box() {
        let grid = Grid::new([10, 10, 10], [1.0; 3]).unwrap();
        let light = Light::towards(DVec3::Y).unwrap();
        let path = LightPath::new(&light, &grid, 0.5);
        // From the centre (4.5) to the face (9.5): 5 voxels = 10 steps; samples at 2, 6 < 10 ≤ 10.
        assert_eq!(path.count([4.5, 4.5, 4.5]), 2);
        assert_eq!(path.position([4.5; 3], 1), [4.5, 7.5, 4.5]);
        assert_eq!(path.count([4.5, 9.6, 4.5]), 0);
    }
}
