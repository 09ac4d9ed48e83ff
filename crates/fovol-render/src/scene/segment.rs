use super::leaving_planes::LeavingPlanes;
use fovol_core::{ClipBox, ClipPlanes, Grid, Light, Ray, RaysBeside};
use glam::DVec3;

/// A grid and a step, prepared to make [`Segment`]s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Segments {
    /// The lowest and the highest corner of the part that rays pass, world units.
    ends: [DVec3; 2],
    /// Planes that cut this part, world units.
    planes: ClipPlanes,
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
            planes: *clip.planes(),
            half: grid.world_extent() * 0.5,
            delta: step * grid.smallest_voxel(),
            to_voxels: grid.voxel_size().recip(),
        }
    }

    /// The samples of `ray`.
    #[inline(always)]
    pub fn of(&self, ray: &Ray) -> Segment {
        let Some((mut near, mut far)) = ray.clip_between(self.ends) else { return Segment::EMPTY };
        for plane in self.planes.as_slice() {
            let DVec3 { x, y, z } = plane.normal;
            let along = x * ray.direction.x + y * ray.direction.y + z * ray.direction.z;
            let away = plane.distance - (x * ray.origin.x + y * ray.origin.y + z * ray.origin.z);
            let [enters, leaves] = through_plane(along, away);
            (near, far) = (larger(near, enters), smaller(far, leaves));
        }
        if near >= far {
            return Segment::EMPTY;
        }
        // Samples k with k + ½ < (far − near)/Δ: ⌈x⌉ as ⌊x⌋ plus one where something is left over.
        let length = (far - near) / self.delta - 0.5;
        let whole = length.max(0.0) as u32;
        let count = whole + u32::from(length > f64::from(whole));
        let first = ray.origin + ray.direction * (near + 0.5 * self.delta);
        let start = (first + self.half) * self.to_voxels - DVec3::splat(0.5);
        let delta = ray.direction * self.delta * self.to_voxels;
        let length = ((far - near) / self.delta) as f32;
        let distance = (near + 0.5 * self.delta) as f32;
        Segment {
            start: start.as_vec3().to_array(),
            delta: delta.as_vec3().to_array(),
            count,
            length,
            distance,
        }
    }

    /// `point` of the world in voxel-centre coordinates.
    pub fn in_voxels(&self, point: DVec3) -> [f32; 3] {
        ((point + self.half) * self.to_voxels - DVec3::splat(0.5)).as_vec3().to_array()
    }

    /// How far sample `number` is from the origin of its ray, whose first sample is `first` away, in world units.
    #[inline(always)]
    pub fn distance(&self, first: f32, number: f32) -> f32 {
        number.mul_add(self.delta as f32, first)
    }

    /// [`Self::of`] for `N` rays side by side: the same numbers from loops without branches, which compilers turn into
    /// vectors.
    #[inline(always)]
    pub fn of_many<const N: usize>(&self, rays: &RaysBeside<N>) -> SegmentsBeside<N> {
        let RaysBeside { origin, direction } = rays;
        let (mut near, mut far) = ([0.0f64; N], [f64::INFINITY; N]);
        for a in 0..3 {
            let [from, to] = self.ends.map(|end| end[a]);
            for i in 0..N {
                let (low, high) = (from - origin[a][i], to - origin[a][i]);
                // Parallel to this slab a ray is inside it all the way or never.
                let inside = low <= 0.0 && 0.0 <= high;
                let always = if inside { 0.0 } else { f64::INFINITY };
                let never = if inside { f64::INFINITY } else { 0.0 };
                let inverse = 1.0 / direction[a][i];
                let (p, q) = (low * inverse, high * inverse);
                let is_parallel = direction[a][i] == 0.0;
                let enters = if is_parallel { always } else { smaller(p, q) };
                let leaves = if is_parallel { never } else { larger(p, q) };
                near[i] = larger(near[i], enters);
                far[i] = smaller(far[i], leaves);
            }
        }
        for plane in self.planes.as_slice() {
            let [x, y, z] = plane.normal.to_array();
            for i in 0..N {
                let along = x * direction[0][i] + y * direction[1][i] + z * direction[2][i];
                let away = plane.distance - (x * origin[0][i] + y * origin[1][i] + z * origin[2][i]);
                let [enters, leaves] = through_plane(along, away);
                (near[i], far[i]) = (larger(near[i], enters), smaller(far[i], leaves));
            }
        }
        let mut out = SegmentsBeside {
            start: [[0.0; N]; 3],
            delta: [[0.0; N]; 3],
            count: [0.0; N],
            length: [0.0; N],
            distance: [0.0; N],
        };
        for i in 0..N {
            let length = (far[i] - near[i]) / self.delta;
            let count = (length - 0.5).ceil();
            out.count[i] = if near[i] < far[i] { larger(count, 0.0) as f32 } else { 0.0 };
            out.length[i] = if near[i] < far[i] { length as f32 } else { 0.0 };
            out.distance[i] = (near[i] + 0.5 * self.delta) as f32;
        }
        for a in 0..3 {
            for i in 0..N {
                let first = origin[a][i] + direction[a][i] * (near[i] + 0.5 * self.delta);
                out.start[a][i] = ((first + self.half[a]) * self.to_voxels[a] - 0.5) as f32;
                out.delta[a][i] = (direction[a][i] * self.delta * self.to_voxels[a]) as f32;
            }
        }
        out
    }
}

/// Where a ray is on the kept side of a plane: from one distance to another. It comes nearer by `along` for each unit of way,
/// and begins `away` from the kept side.
#[inline(always)]
fn through_plane(along: f64, away: f64) -> [f64; 2] {
    let crossing = away / along;
    let enters = if along > 0.0 { crossing } else { 0.0 };
    let outside = if away > 0.0 { f64::NEG_INFINITY } else { f64::INFINITY };
    let leaves = if along < 0.0 {
        crossing
    } else if along > 0.0 {
        f64::INFINITY
    } else {
        outside
    };
    [enters, leaves]
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
    /// How far the first samples are from the origins of their rays, in world units.
    pub distance: [f32; N],
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
    /// How far the first sample is from the origin of the ray, in world units.
    pub distance: f32,
}

impl Segment {
    /// A ray that misses the box.
    pub const EMPTY: Self = Self { start: [0.0; 3], delta: [0.0; 3], count: 0, length: 0.0, distance: 0.0 };

    /// Where the ray is `steps` steps after it entered the box, and never beyond the box.
    #[inline(always)]
    pub fn boundary(&self, steps: f32) -> [f32; 3] {
        let from_first = steps.min(self.length) - 0.5;
        std::array::from_fn(|a| from_first.mul_add(self.delta[a], self.start[a]))
    }

    /// Where sample `k` lies.
    #[inline(always)]
    pub fn position(&self, k: u32) -> [f32; 3] {
        self.at(k as f32)
    }

    /// Where sample `number` lies, which may be between two.
    #[inline(always)]
    pub fn at(&self, number: f32) -> [f32; 3] {
        std::array::from_fn(|a| number.mul_add(self.delta[a], self.start[a]))
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
    /// The planes that the light comes through.
    pub planes: LeavingPlanes,
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
        Self { delta, exit, inverse, planes: LeavingPlanes::new(clip.planes(), grid, delta) }
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
        for [x, y, z, w] in self.planes.as_slice() {
            distance = distance.min(x.mul_add(p[0], y.mul_add(p[1], z.mul_add(p[2], *w))));
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
        self.at(p, SHADOW_STEP.mul_add(j as f32, SHADOW_START))
    }

    /// The place `steps` primary steps from `p` towards the light.
    #[inline(always)]
    pub fn at(&self, p: [f32; 3], steps: f32) -> [f32; 3] {
        std::array::from_fn(|a| steps.mul_add(self.delta[a], p[a]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovol_core::{ClipPlane, Projection};
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
            for projection in [Projection::Perspective, Projection::Orthographic] {
            let camera = fovol_core::Camera { projection, ..camera };
            let rays = camera.rays(fovol_core::FrameSize::new(1281, 1281).unwrap());
            let whole = ClipBox::whole(&grid);
            let part = ClipBox::new(DVec3::new(3.3, 0.0, 21.9), DVec3::new(64.0, 17.2, 44.0), &grid).unwrap();
            let planes = [(DVec3::new(0.3, -0.5, 0.8), -0.1), (DVec3::NEG_Y, -0.2), (DVec3::X, -0.4)];
            let planes = planes.map(|(normal, distance)| ClipPlane { normal, distance });
            let cut = part.with_planes(ClipPlanes::new(&planes).unwrap());
            for segments in [whole, part, cut].map(|clip| Segments::new(&grid, &clip, step)) {
            // A corner of the picture, and its very middle.
            for [x0, y0] in [corner, [636, 636]] {
                let x = std::array::from_fn(|i| f64::from(x0 + i as u32));
                let y = [f64::from(y0 + 4); 8];
                let many = segments.of_many(&rays.beside(&x, &y));
                for i in 0..8 {
                    let one = segments.of(&rays.ray(x0 + i as u32, y0 + 4));
                    prop_assert_eq!(many.count[i], one.count as f32);
                    if one.count > 0 {
                        prop_assert_eq!(many.start.map(|s| s[i]), one.start);
                        prop_assert_eq!(many.delta.map(|d| d[i]), one.delta);
                        prop_assert_eq!(many.distance[i], one.distance);
                    }
                }
            }
            }
            }
        }
    }

    proptest! {
        #[test]
        fn rays_and_light_end_at_planes(
            normal in prop::array::uniform3(-1.0f64..1.0), distance in -0.3f64..0.3,
            eye in prop::array::uniform3(-2.0f64..2.0), light in prop::array::uniform3(-1.0f64..1.0),
            pixel in prop::array::uniform2(0u32..16),
        ) {
            let (normal, light) = (DVec3::from(normal), DVec3::from(light));
            prop_assume!(normal.length() > 0.1 && light.length() > 0.1);
            let grid = Grid::new([30, 21, 44], [1.0, 2.0, 1.5]).unwrap();
            let planes = ClipPlanes::new(&[ClipPlane { normal, distance }]).unwrap();
            let clip = ClipBox::whole(&grid).with_planes(planes);
            let camera = fovol_core::Camera::new(eye.into(), DVec3::splat(0.03), 40.0).unwrap();
            let ray = camera.rays(fovol_core::FrameSize::new(16, 16).unwrap()).ray(pixel[0], pixel[1]);
            let path = LightPath::new(&Light::towards(light).unwrap(), &grid, &clip, 0.5);
            let [cut, whole] = [clip, ClipBox::whole(&grid)].map(|clip| Segments::new(&grid, &clip, 0.1).of(&ray));
            let beyond = |p: [f32; 3]| {
                let at = DVec3::from_array(p.map(f64::from)) + 0.5;
                normal.dot(grid.grid_to_world(at)) - distance
            };
            for k in 0..cut.count {
                let p = cut.position(k);
                prop_assert!(beyond(p) > -1e-6, "sample {} is {} beyond", k, beyond(p));
                let end = path.at(p, path.way_out(p));
                let inside = |at: f32, high: usize| (-0.51..high as f32 - 0.49).contains(&at);
                let is_in_box = (0..3).all(|a| inside(end[a], grid.dims()[a]));
                prop_assert!(is_in_box && beyond(end) > -1e-4, "{:?} {}", end, beyond(end));
            }
            // Nothing that is kept is lost.
            let kept = (0..whole.count).filter(|&k| beyond(whole.position(k)) > 0.0).count();
            prop_assert!(kept.abs_diff(cut.count as usize) <= 1, "{} {}", kept, cut.count);
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
