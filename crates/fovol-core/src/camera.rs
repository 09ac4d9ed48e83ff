use crate::{Error, FrameSize, Grid, Projection, Result};
use glam::{DMat3, DVec3};
use serde::{Deserialize, Serialize};

/// Camera. Its space is world space with +y up, unless it was [turned](Self::turned).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Camera {
    /// Position of the eye.
    pub eye: DVec3,
    /// Point at the centre of the picture.
    pub target: DVec3,
    /// Vertical field of view in degrees, above 0 and below 180. An orthographic picture shows as much as this angle
    /// does at the target.
    pub fovy: f64,
    /// How it projects.
    #[serde(default)]
    pub projection: Projection,
    /// Rotation from the space of `eye` and `target` to world space, where +y is up: an orthogonal matrix.
    #[serde(skip)]
    pub upright: DMat3,
}

/// Ray with a unit `direction`; distances are in world units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    /// Origin.
    pub origin: DVec3,
    /// Direction; length 1.
    pub direction: DVec3,
}

impl Ray {
    /// Interval of the ray inside the box of `grid`: (t_near, t_far) with t_near = max(0, entry), or `None` if the
    /// ray misses it.
    #[inline]
    pub fn clip(&self, grid: &Grid) -> Option<(f64, f64)> {
        self.clip_to(grid.world_extent() * 0.5)
    }

    /// Interval of the ray inside the centred box from −`half` to `half`, as in [`Self::clip`].
    #[inline]
    pub fn clip_to(&self, half: DVec3) -> Option<(f64, f64)> {
        self.clip_between([-half, half])
    }

    /// Interval of the ray inside the box between its lowest and highest corner, as in [`Self::clip`].
    #[inline]
    pub fn clip_between(&self, [low, high]: [DVec3; 2]) -> Option<(f64, f64)> {
        let inverse = self.direction.recip();
        let (a, b) = ((low - self.origin) * inverse, (high - self.origin) * inverse);
        let (mut near, mut far) = (0.0f64, f64::INFINITY);
        for axis in 0..3 {
            if self.direction[axis] == 0.0 {
                // Parallel to this slab: 0 · ∞ is undefined, so compare positions instead.
                if self.origin[axis] < low[axis] || self.origin[axis] > high[axis] {
                    return None;
                }
                continue;
            }
            near = near.max(a[axis].min(b[axis]));
            far = far.min(a[axis].max(b[axis]));
        }
        (near < far).then_some((near, far))
    }
}

/// Camera prepared for one frame size; generates the ray of any pixel.
#[derive(Debug, Clone, Copy)]
pub struct RayBasis {
    /// The eye. With parallel rays it is the origin of the ray through the picture's centre.
    eye: DVec3,
    forward: DVec3,
    right: DVec3,
    up: DVec3,
    size: [f64; 2],
    projection: Projection,
}

/// Rays of `N` pixels side by side, with x, y and z in separate arrays.
#[derive(Debug, Clone, Copy)]
pub struct RaysBeside<const N: usize> {
    /// Origins.
    pub origin: [[f64; N]; 3],
    /// Directions; length 1.
    pub direction: [[f64; N]; 3],
}

impl RayBasis {
    /// Ray through the centre of pixel (`x`, `y`); row 0 is on top.
    #[inline]
    pub fn ray(&self, x: u32, y: u32) -> Ray {
        let u = (f64::from(x) + 0.5) / self.size[0] * 2.0 - 1.0;
        let v = 1.0 - (f64::from(y) + 0.5) / self.size[1] * 2.0;
        match self.projection {
            Projection::Perspective => {
                let direction = (self.forward + self.right * u + self.up * v).normalize();
                Ray { origin: self.eye, direction }
            }
            Projection::Orthographic => {
                Ray { origin: self.eye + self.right * u + self.up * v, direction: self.forward }
            }
        }
    }

    /// [`Self::ray`] for `N` pixels.
    #[inline(always)]
    pub fn beside<const N: usize>(&self, x: &[f64; N], y: &[f64; N]) -> RaysBeside<N> {
        match self.projection {
            Projection::Perspective => {
                RaysBeside { origin: self.eye.to_array().map(|at| [at; N]), direction: self.directions(x, y) }
            }
            Projection::Orthographic => RaysBeside {
                origin: self.origins(x, y),
                direction: self.forward.to_array().map(|along| [along; N]),
            },
        }
    }

    /// Origins of parallel rays.
    #[inline(always)]
    fn origins<const N: usize>(&self, x: &[f64; N], y: &[f64; N]) -> [[f64; N]; 3] {
        let mut from = [[0.0; N]; 3];
        for i in 0..N {
            let u = (x[i] + 0.5) / self.size[0] * 2.0 - 1.0;
            let v = 1.0 - (y[i] + 0.5) / self.size[1] * 2.0;
            for a in 0..3 {
                from[a][i] = self.eye[a] + self.right[a] * u + self.up[a] * v;
            }
        }
        from
    }

    /// Directions of perspective rays. The loops have no branches, so that compilers vectorise them.
    #[inline(always)]
    fn directions<const N: usize>(&self, x: &[f64; N], y: &[f64; N]) -> [[f64; N]; 3] {
        let mut along = [[0.0; N]; 3];
        for i in 0..N {
            let u = (x[i] + 0.5) / self.size[0] * 2.0 - 1.0;
            let v = 1.0 - (y[i] + 0.5) / self.size[1] * 2.0;
            for a in 0..3 {
                along[a][i] = self.forward[a] + self.right[a] * u + self.up[a] * v;
            }
        }
        for i in 0..N {
            let [x, y, z] = [along[0][i], along[1][i], along[2][i]];
            let reciprocal = 1.0 / (x * x + y * y + z * z).sqrt();
            for a in 0..3 {
                along[a][i] *= reciprocal;
            }
        }
        along
    }

    /// Vectors from the eye to the picture's centre, and from there to the right and the upper edge. Directions of
    /// perspective rays are sums of these. Parallel rays have the first as direction, and their origins differ by the
    /// others.
    pub fn axes(&self) -> [DVec3; 3] {
        [self.forward, self.right, self.up]
    }

    /// Origin of the ray through the picture's centre, and of all others unless they are parallel.
    #[inline]
    pub fn origin(&self) -> DVec3 {
        self.eye
    }

    /// How rays project.
    pub fn projection(&self) -> Projection {
        self.projection
    }
}

/// Distance of the origins of parallel rays from the plane through the centre of the world. The corners of a volume are
/// at most half the diagonal of a unit cube away, 0.87.
const PLANE: f64 = 1.0;

impl Camera {
    /// Camera of `[eye x, y, z, target x, y, z, fovy]`.
    ///
    /// # Errors
    /// Numbers that are not finite, an eye on its target, a field of view outside (0, 180).
    pub fn new(eye: DVec3, target: DVec3, fovy: f64) -> Result<Self> {
        let camera = Self::at(eye, target, fovy);
        camera.check()?;
        Ok(camera)
    }

    /// Camera in world space from valid numbers, without the checks of [`Self::new`].
    pub const fn at(eye: DVec3, target: DVec3, fovy: f64) -> Self {
        Self { eye, target, fovy, projection: Projection::Perspective, upright: DMat3::IDENTITY }
    }

    /// Transforms the camera to another space by the orthogonal matrix `turn`; it sees there what it saw here. A
    /// mirroring `turn` mirrors the camera, so that pictures of a mirrored volume are not mirrored.
    #[must_use]
    pub fn turned(&self, turn: &DMat3) -> Self {
        Self {
            eye: *turn * self.eye,
            target: *turn * self.target,
            upright: self.upright * turn.transpose(),
            ..*self
        }
    }

    /// Checks that the camera can be used.
    ///
    /// # Errors
    /// Errors of [`Self::new`].
    pub fn check(&self) -> Result<()> {
        crate::checked(
            "field of view",
            self.fovy,
            "an angle above 0 and below 180 degrees",
            self.fovy > 0.0 && self.fovy < 180.0,
        )?;
        let distance = (self.eye - self.target).length();
        if !distance.is_finite() || distance < 1e-9 {
            return Err(Error::CameraPath(
                "eye and target coincide or are not finite; give two different points".into(),
            ));
        }
        Ok(())
    }

    /// Camera on a sphere of radius `distance` around the origin. `azimuth` 0 is at +z and turns towards +x,
    /// `elevation` rises towards +y; both in degrees.
    pub fn on_sphere(azimuth: f64, elevation: f64, distance: f64, fovy: f64) -> Self {
        let (a, e) = (azimuth.to_radians(), elevation.to_radians());
        let eye = DVec3::new(a.sin() * e.cos(), e.sin(), a.cos() * e.cos()) * distance;
        Self::at(eye, DVec3::ZERO, fovy)
    }

    /// Unit vectors (forward, right, up). In world space right = forward × +y, or +x when looking straight up or
    /// down.
    pub fn axes(&self) -> (DVec3, DVec3, DVec3) {
        let forward = (self.upright * (self.target - self.eye)).normalize();
        let right = forward.cross(DVec3::Y);
        let right = if right.length_squared() < 1e-18 { DVec3::X } else { right.normalize() };
        let back = self.upright.transpose();
        (back * forward, back * right, back * right.cross(forward))
    }

    /// Prepares the camera for frames of `size`.
    ///
    /// Parallel rays begin on a plane in front of everything, at a distance of 1 from the centre of the world.
    pub fn rays(&self, size: FrameSize) -> RayBasis {
        let (forward, right, up) = self.axes();
        let height = (self.fovy.to_radians() * 0.5).tan();
        let (eye, height) = match self.projection {
            Projection::Perspective => (self.eye, height),
            Projection::Orthographic => {
                let to_plane = -PLANE - self.eye.dot(forward);
                (self.eye + forward * to_plane, height * (self.target - self.eye).length())
            }
        };
        let (w, h) = (f64::from(size.width), f64::from(size.height));
        RayBasis {
            eye,
            forward,
            right: right * (height * w / h),
            up: up * height,
            size: [w, h],
            projection: self.projection,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn right_is_right_and_row_zero_is_on_top() {
        let camera = Camera::on_sphere(0.0, 0.0, 2.0, 90.0);
        let rays = camera.rays(FrameSize::new(101, 51).unwrap());
        assert!((rays.ray(50, 25).direction - DVec3::NEG_Z).length() < 1e-12);
        assert!(rays.ray(100, 25).direction.x > 0.0);
        assert!(rays.ray(50, 0).direction.y > 0.0);
    }

    #[test]
    fn turned_cameras_see_what_they_saw() {
        let turns = [
            DMat3::from_cols(DVec3::NEG_Z, DVec3::X, DVec3::NEG_Y),
            DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0)),
        ];
        let size = FrameSize::new(40, 30).unwrap();
        for camera in [Camera::on_sphere(30.0, 20.0, 2.0, 40.0), Camera::on_sphere(0.0, 90.0, 2.0, 40.0)] {
            for turn in turns {
                let turned = camera.turned(&turn);
                let [here, there] = [camera, turned].map(|camera| camera.rays(size).ray(3, 7));
                assert!((turn * here.direction - there.direction).length() < 1e-12);
                assert!((turn * here.origin - there.origin).length() < 1e-12);
                let back = turned.turned(&turn.transpose());
                assert!((back.eye - camera.eye).length() < 1e-12);
            }
        }
    }

    #[test]
    fn parallel_pictures_are_as_high_as_perspective_ones_at_the_target() {
        let size = FrameSize::new(160, 90).unwrap();
        // Also from within the volume, which then is seen as from outside.
        for distance in [0.2, 2.5, 300.0] {
            let camera = Camera::on_sphere(30.0, 20.0, distance, 40.0);
            let camera = Camera { target: DVec3::new(0.1, -0.2, 0.05), ..camera };
            let parallel = Camera { projection: Projection::Orthographic, ..camera };
            let (forward, _, up) = camera.axes();
            let rays = parallel.rays(size);
            let [top, bottom] = [0, 89].map(|y| rays.ray(80, y));
            let high = (top.origin - bottom.origin).dot(up) * 90.0 / 89.0;
            let seen = 2.0 * (camera.eye - camera.target).length() * 20f64.to_radians().tan();
            assert!((high / seen - 1.0).abs() < 1e-9, "{high} {seen}");
            assert!(
                (top.direction - forward).length() < 1e-12 && (top.origin.dot(forward) + 1.0).abs() < 1e-9
            );
            // The target is in the middle.
            let middle = rays.origin() - camera.target;
            assert!((middle - forward * middle.dot(forward)).length() < 1e-9);
            let beside = rays.beside(&[80.0, 3.0], &[0.0, 71.0]);
            for (i, ray) in [top, rays.ray(3, 71)].into_iter().enumerate() {
                assert_eq!(beside.origin.map(|o| o[i]), ray.origin.to_array());
                assert_eq!(beside.direction.map(|d| d[i]), ray.direction.to_array());
            }
        }
    }

    #[test]
    fn a_vertical_view_has_axes() {
        let camera = Camera::on_sphere(0.0, 90.0, 2.0, 35.0);
        let (f, r, u) = camera.axes();
        assert!(f.is_finite() && r.is_finite() && u.is_finite());
    }

    #[test]
    fn clipping_starts_at_the_eye_when_inside() {
        let grid = Grid::new([4, 4, 4], [1.0; 3]).unwrap();
        let ray = Ray { origin: DVec3::ZERO, direction: DVec3::X };
        assert_eq!(ray.clip(&grid), Some((0.0, 0.5)));
        let ray = Ray { origin: DVec3::new(0.0, 0.6, 0.0), direction: DVec3::X };
        assert_eq!(ray.clip(&grid), None);
    }

    proptest! {
        #[test]
        fn clipped_interval_lies_in_the_box(
            azimuth in 0.0f64..360.0, elevation in -90.0f64..90.0, distance in 0.1f64..4.0,
            x in 0u32..64, y in 0u32..32, dims in prop::array::uniform3(1usize..40),
        ) {
            let grid = Grid::new(dims, [1.0; 3]).unwrap();
            let ray = Camera::on_sphere(azimuth, elevation, distance, 35.0)
                .rays(FrameSize::new(64, 32).unwrap()).ray(x, y);
            if let Some((near, far)) = ray.clip(&grid) {
                let middle = ray.origin + ray.direction * (0.5 * (near + far));
                prop_assert!((middle.abs() - grid.world_extent() * 0.5).max_element() < 1e-9);
            }
        }
    }
}
