use fovol_core::{ClipBox, Grid, Light, Ray};
use glam::DVec3;

/// A grid and a step, prepared to make [`Segment`]s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Segments {
    /// The lowest and the highest corner of the part that rays pass, world units.
    ends: [DVec3; 2],
    /// Half the extent of the grid, world units.
    half: DVec3,
    /// Δ in world units.
    delta: f64,
    /// From world units to voxels.
    to_voxels: DVec3,
}

impl Segments {
    /// Segments of rays through the part `clip` of `grid` at distances of `step` voxels (of the smallest spacing).
    pub fn new(grid: &Grid, clip: &ClipBox, step: f64) -> Self {
        Self {
            ends: clip.in_world(grid),
            half: grid.world_extent() * 0.5,
            delta: step * grid.smallest_voxel(),
            to_voxels: grid.voxel_size().recip(),
        }
    }

    /// The samples of `ray`.
    #[inline(always)]
    pub fn of(&self, ray: &Ray) -> Segment {
        let Some((near, far)) = ray.clip_between(self.ends) else { return Segment::EMPTY };
        // Samples k with k + ½ < (far − near)/Δ: ⌈x⌉ as ⌊x⌋ plus one where something is left over.
        let length = (far - near) / self.delta - 0.5;
        let whole = length.max(0.0) as u32;
        let count = whole + u32::from(length > f64::from(whole));
        let first = ray.origin + ray.direction * (near + 0.5 * self.delta);
        let start = (first + self.half) * self.to_voxels - DVec3::splat(0.5);
        let delta = ray.direction * self.delta * self.to_voxels;
        let length = ((far - near) / self.delta) as f32;
        Segment { start: start.as_vec3().to_array(), delta: delta.as_vec3().to_array(), count, length }
    }

    /// `point` of the world in voxel-centre coordinates.
    pub fn in_voxels(&self, point: DVec3) -> [f32; 3] {
        ((point + self.half) * self.to_voxels - DVec3::splat(0.5)).as_vec3().to_array()
    }

    /// How far in world units the point `number` steps of `delta` on from `start` is from `eye`, all three in
    /// voxels.
    #[inline(always)]
    pub fn distance(&self, eye: [f32; 3], start: [f32; 3], delta: [f32; 3], number: f32) -> f32 {
        let mut squared = 0.0f32;
        for a in 0..3 {
            let way = (number.mul_add(delta[a], start[a]) - eye[a]) / self.to_voxels[a] as f32;
            squared = way.mul_add(way, squared);
        }
        squared.sqrt()
    }

    /// [`Self::of`] for `N` rays from `origin` side by side: the same numbers from loops without branches,
    /// which compilers turn into vectors.
    #[inline(always)]
    pub fn of_many<const N: usize>(&self, origin: DVec3, direction: &[[f64; N]; 3]) -> SegmentsBeside<N> {
        let (mut near, mut far) = ([0.0f64; N], [f64::INFINITY; N]);
        for a in 0..3 {
            let [from, to] = self.ends.map(|end| end[a]);
            let (low, high) = (from - origin[a], to - origin[a]);
            // Parallel to this slab a ray is inside it all the way or never.
            let inside = from <= origin[a] && origin[a] <= to;
            let (always, never) = if inside { (0.0, f64::INFINITY) } else { (f64::INFINITY, 0.0) };
            for i in 0..N {
                let inverse = 1.0 / direction[a][i];
                let (p, q) = (low * inverse, high * inverse);
                let is_parallel = direction[a][i] == 0.0;
                let enters = if is_parallel { always } else { smaller(p, q) };
                let leaves = if is_parallel { never } else { larger(p, q) };
                near[i] = larger(near[i], enters);
                far[i] = smaller(far[i], leaves);
            }
        }
        let mut out =
            SegmentsBeside { start: [[0.0; N]; 3], delta: [[0.0; N]; 3], count: [0.0; N], length: [0.0; N] };
        for i in 0..N {
            let length = (far[i] - near[i]) / self.delta;
            let count = (length - 0.5).ceil();
            out.count[i] = if near[i] < far[i] { larger(count, 0.0) as f32 } else { 0.0 };
            out.length[i] = if near[i] < far[i] { length as f32 } else { 0.0 };
        }
        for a in 0..3 {
            for i in 0..N {
                let first = origin[a] + direction[a][i] * (near[i] + 0.5 * self.delta);
                out.start[a][i] = ((first + self.half[a]) * self.to_voxels[a] - 0.5) as f32;
                out.delta[a][i] = (direction[a][i] * self.delta * self.to_voxels[a]) as f32;
            }
        }
        out
    }
}

/// The smaller of two numbers, as one instruction.
#[inline(always)]
fn smaller(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// The larger of two numbers, as one instruction.
#[inline(always)]
fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// [`Segment`]s of `N` rays, each number in an array of its own.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SegmentsBeside<const N: usize> {
    /// The first samples.
    pub start: [[f32; N]; 3],
    /// From one sample to the next.
    pub delta: [[f32; N]; 3],
    /// How many samples there are.
    pub count: [f32; N],
    /// How many steps it is through the box; not whole.
    pub length: [f32; N],
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
    /// How many steps it is through the box; not whole.
    pub length: f32,
}

impl Segment {
    /// A ray that misses the box.
    pub const EMPTY: Self = Self { start: [0.0; 3], delta: [0.0; 3], count: 0, length: 0.0 };

    /// Where the ray is `steps` steps after it entered the box, and never beyond the box.
    #[inline(always)]
    pub fn boundary(&self, steps: f32) -> [f32; 3] {
        let from_first = steps.min(self.length) - 0.5;
        std::array::from_fn(|a| from_first.mul_add(self.delta[a], self.start[a]))
    }

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

/// Shadow steps are this many primary steps long (docs/guide/src/internals/algorithm.md, section 3).
pub const SHADOW_STEP: f32 = 4.0;
/// The first shadow sample is this many primary steps from its point.
pub const SHADOW_START: f32 = 2.0;

impl LightPath {
    /// The way from any point of the part `clip` of `grid` towards `light` at primary steps of `step` voxels.
    pub fn new(light: &Light, grid: &Grid, clip: &ClipBox, step: f64) -> Self {
        let delta =
            (light.direction() * (step * grid.smallest_voxel()) / grid.voxel_size()).as_vec3().to_array();
        let [low, high] = clip.in_voxels();
        let exit = std::array::from_fn(|a| if delta[a] > 0.0 { high[a] } else { low[a] });
        // A vanishing component never leaves: a huge inverse of either sign would, so make it plainly infinite.
        let inverse = delta.map(|d| if d.abs() < 1e-20 { f32::INFINITY } else { 1.0 / d });
        Self { delta, exit, inverse }
    }

    /// How many steps it is from `p` (voxel-centre coordinates) out of the box.
    #[inline]
    pub fn way_out(&self, p: [f32; 3]) -> f32 {
        let mut distance = f32::INFINITY;
        for a in 0..3 {
            if self.inverse[a].is_finite() {
                distance = distance.min((self.exit[a] - p[a]) * self.inverse[a]);
            }
        }
        distance
    }

    /// How many shadow samples lie between `p` (voxel-centre coordinates) and the box.
    #[inline]
    pub fn count(&self, p: [f32; 3]) -> u32 {
        // 2 + 4j < distance
        ((self.way_out(p) - SHADOW_START) / SHADOW_STEP).ceil() as u32
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
    use proptest::prelude::*;

    #[test]
    fn samples_are_half_a_step_in_and_stop_before_the_far_face() {
        let grid = Grid::new([10, 10, 10], [1.0; 3]).unwrap();
        let ray = Ray { origin: DVec3::new(-2.0, 0.0, 0.0), direction: DVec3::X };
        let segment = Segments::new(&grid, &ClipBox::whole(&grid), 0.5).of(&ray);
        assert_eq!(segment.count, 20);
        assert!((segment.position(0)[0] - (0.25 - 0.5)).abs() < 1e-5);
        assert!((segment.position(19)[0] - (9.75 - 0.5)).abs() < 1e-5);
    }

    proptest! {
        #[test]
        fn many_rays_are_as_single_ones(
            eye in prop::array::uniform3(-2.0f64..2.0),
            target in prop::sample::select(vec![DVec3::ZERO, DVec3::new(0.1, -0.2, 0.3)]),
            axis in 0usize..4,
            corner in prop::array::uniform2(0u32..1270),
            step in 0.2f64..2.0,
        ) {
            // Also eyes on an axis, whose rays can be parallel to faces.
            let mut eye = DVec3::from_array(eye);
            if axis < 3 {
                eye = DVec3::AXES[axis] * 1.7;
            }
            let grid = Grid::new([70, 31, 44], [1.0, 2.0, 1.5]).unwrap();
            let camera = fovol_core::Camera::new(eye, target, 40.0).unwrap();
            let rays = camera.rays(fovol_core::FrameSize::new(1281, 1281).unwrap());
            let whole = ClipBox::whole(&grid);
            let part = ClipBox::new(DVec3::new(3.3, 0.0, 21.9), DVec3::new(64.0, 17.2, 44.0), &grid).unwrap();
            for segments in [whole, part].map(|clip| Segments::new(&grid, &clip, step)) {
            // A corner of the picture, and its very middle.
            for [x0, y0] in [corner, [636, 636]] {
                let x = std::array::from_fn(|i| f64::from(x0 + i as u32));
                let y = [f64::from(y0 + 4); 8];
                let many = segments.of_many(rays.origin(), &rays.directions(&x, &y));
                for i in 0..8 {
                    let one = segments.of(&rays.ray(x0 + i as u32, y0 + 4));
                    prop_assert_eq!(many.count[i], one.count as f32);
                    if one.count > 0 {
                        prop_assert_eq!(many.start.map(|s| s[i]), one.start);
                        prop_assert_eq!(many.delta.map(|d| d[i]), one.delta);
                    }
                }
            }
            }
        }
    }

    #[test]
    fn shadow_samples_stop_before_the_box() {
        let grid = Grid::new([10, 10, 10], [1.0; 3]).unwrap();
        let light = Light::towards(DVec3::Y).unwrap();
        let path = LightPath::new(&light, &grid, &ClipBox::whole(&grid), 0.5);
        // From the centre (4.5) to the face (9.5): 5 voxels = 10 steps; samples at 2, 6 < 10 ≤ 10.
        assert_eq!(path.count([4.5, 4.5, 4.5]), 2);
        assert_eq!(path.position([4.5; 3], 1), [4.5, 7.5, 4.5]);
        assert_eq!(path.count([4.5, 9.6, 4.5]), 0);
    }
}
