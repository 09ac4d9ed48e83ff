use crate::{Camera, FrameSize, Projection};
use glam::{DMat3, DVec3, Vec3};

/// Mapping of pixels from one frame to another by the cameras of both.
///
/// A point seen at pixel (x, y) at distance t lies at eye + t·d/|d|, with d the direction through the pixel, linear
/// in (x, y). In the other camera's axes that is t/|d| · (M·d + |d|/t · m). The factor before the bracket does not
/// change the projection. So the other pixel comes from M·d + w·|d|·m with the inverse distance w = 1/t, which also
/// works at infinity (w = 0).
///
/// Parallel rays begin at points that are linear in (x, y), so that the other pixel comes from M·(begin − other begin) +
/// t·m with m the direction in the other camera's axes. What is infinitely far away moves as the centre of the world.
#[derive(Debug, Clone, Copy)]
pub struct Reprojection {
    /// M·d for pixel (0, 0), and its increments per pixel right and down. With parallel rays d is the way between the two
    /// origins.
    base: [Vec3; 3],
    /// d for pixel (0, 0), and its increments per pixel right and down.
    direction: [Vec3; 3],
    /// m, the translation in the other camera's axes; with parallel rays the direction.
    parallax: Vec3,
    /// Half width and half height of the other camera's view at distance 1.
    half: [f32; 2],
    size: [f32; 2],
    /// Pixel of the whole frame that counts as (0, 0).
    corner: [f32; 2],
    projection: Projection,
}

impl Reprojection {
    /// Mapping from pixels of `camera` to pixels of `other`, both with frames of `size`. Between cameras of different
    /// projections nothing moves.
    pub fn new(camera: &Camera, other: &Camera, size: FrameSize) -> Self {
        let camera = if camera.projection == other.projection { camera } else { other };
        let (w, h) = (f64::from(size.width), f64::from(size.height));
        let [here, there] = [camera, other].map(|camera| camera.rays(size));
        let [ahead, right, up] = here.axes();
        let across = right * (2.0 / w);
        let down = -up * (2.0 / h);
        let way = here.origin() - there.origin();
        let (from, moved) = match camera.projection {
            Projection::Perspective => (ahead, way),
            Projection::Orthographic => (way, ahead),
        };
        let first = from - right + up + (across + down) * 0.5;
        let [forward, right, up] = there.axes();
        let half = [right, up].map(|side| side.length() as f32);
        // Rows that give the depth along the view, and the position in −1…1 times the depth.
        let rows = [forward, right / right.length_squared(), up / up.length_squared()];
        let project = DMat3::from_cols(rows[0], rows[1], rows[2]).transpose();
        let directions = [first, across, down];
        Self {
            base: directions.map(|d| (project * d).as_vec3()),
            direction: directions.map(DVec3::as_vec3),
            parallax: (project * moved).as_vec3(),
            half,
            size: [w as f32, h as f32],
            corner: [0.0; 2],
            projection: camera.projection,
        }
    }

    /// Restricts the mapping to a part of both frames; pixels then count from its top left pixel (`x`, `y`).
    #[must_use]
    pub fn of_part(mut self, x: u32, y: u32) -> Self {
        let (x, y) = (x as f32, y as f32);
        for v in [&mut self.base, &mut self.direction] {
            v[0] += v[1] * x + v[2] * y;
        }
        self.corner = [self.corner[0] + x, self.corner[1] + y];
        self
    }

    /// Coefficients for shaders: M·d for pixel (0, 0) and its increments per pixel right and down; the three vectors
    /// of d; and m.
    pub fn coefficients(&self) -> [Vec3; 7] {
        let ([a, b, c], [d, e, f]) = (self.base, self.direction);
        [a, b, c, d, e, f, self.parallax]
    }

    /// Half width and half height of the other camera's view at distance 1, which [`Self::point`] needs besides.
    pub fn half_extent(&self) -> [f32; 2] {
        self.half
    }

    /// How both cameras project.
    pub fn projection(&self) -> Projection {
        self.projection
    }

    /// Motion in pixels, x right and y down, from pixel (`x`, `y`) to the position of its point in the other frame.
    /// `inverse_distance` is one over the point's distance from the eye, in world units. Points behind the other
    /// camera land far outside.
    #[inline(always)]
    pub fn motion(&self, x: f32, y: f32, inverse_distance: f32) -> [f32; 2] {
        let (seen, _) = self.seen(x, y, inverse_distance);
        let [to_x, to_y] = self.place(seen, self.depth_of(seen).max(1e-6));
        [to_x - x, to_y - y]
    }

    /// Position in the other frame (in pixels, with fractions) of the point that pixel (`x`, `y`) shows, and one over
    /// its distance from the other eye. `inverse_distance` is one over its distance from this eye. `None` behind the
    /// other eye.
    #[inline(always)]
    pub fn point(&self, x: f32, y: f32, inverse_distance: f32) -> Option<([f32; 2], f32)> {
        let (seen, scale) = self.seen(x, y, inverse_distance);
        if seen.x <= 1e-6 {
            return None;
        }
        let inverse = match self.projection {
            Projection::Perspective => {
                scale / Vec3::new(seen.x, seen.y * self.half[0], seen.z * self.half[1]).length()
            }
            Projection::Orthographic => 1.0 / seen.x,
        };
        Some((self.place(seen, self.depth_of(seen)), inverse))
    }

    /// Divisor of positions in the other picture.
    #[inline(always)]
    fn depth_of(&self, seen: Vec3) -> f32 {
        match self.projection {
            Projection::Perspective => seen.x,
            Projection::Orthographic => 1.0,
        }
    }

    /// M·d + w·|d|·m, the point in the axes of the other camera times w·|d|; and the factor w·|d|. With parallel rays it
    /// is the point itself, and the factor is the distance.
    #[inline(always)]
    fn seen(&self, x: f32, y: f32, inverse_distance: f32) -> (Vec3, f32) {
        let at = |v: &[Vec3; 3]| v[0] + v[1] * x + v[2] * y;
        let scale = match self.projection {
            Projection::Perspective => inverse_distance * at(&self.direction).length(),
            Projection::Orthographic if inverse_distance > 0.0 => 1.0 / inverse_distance,
            Projection::Orthographic => 1.0,
        };
        (at(&self.base) + self.parallax * scale, scale)
    }

    /// Pixel position of `seen` at the depth `ahead`.
    #[inline(always)]
    fn place(&self, seen: Vec3, ahead: f32) -> [f32; 2] {
        let ([w, h], [left, top]) = (self.size, self.corner);
        [(seen.y / ahead + 1.0) * 0.5 * w - 0.5 - left, (1.0 - seen.z / ahead) * 0.5 * h - 0.5 - top]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn camera() -> impl Strategy<Value = Camera> {
        (0.0f64..360.0, -80.0f64..80.0, 1.0f64..4.0, 20.0f64..80.0).prop_map(
            |(azimuth, elevation, distance, fovy)| Camera::on_sphere(azimuth, elevation, distance, fovy),
        )
    }

    proptest! {
        #[test]
        fn a_point_is_found_where_the_other_ray_meets_it(
            a in camera(), turn in -10.0f64..10.0, rise in -5.0f64..5.0, closer in 0.9f64..1.1,
            x in 0u32..200, y in 0u32..100, t in 0.5f64..4.0,
        ) {
            let size = FrameSize::new(200, 100).unwrap();
            let b = Camera { eye: glam::DQuat::from_rotation_y(turn.to_radians()) * (a.eye * closer) + DVec3::Y * (rise * 0.05), ..a };
            let ray = a.rays(size).ray(x, y);
            let point = ray.origin + ray.direction * t;
            let [dx, dy] = Reprojection::new(&a, &b, size).motion(x as f32, y as f32, (1.0 / t) as f32);
            let (forward, right, up) = b.axes();
            let way = point - b.eye;
            let depth = way.dot(forward);
            prop_assume!(depth > 0.1);
            let height = (b.fovy.to_radians() * 0.5).tan();
            let (u, v) = (way.dot(right) / depth / (height * 2.0), way.dot(up) / depth / height);
            let expected = [(u + 1.0) * 100.0 - 0.5, (1.0 - v) * 50.0 - 0.5];
            let found = [f64::from(x) + f64::from(dx), f64::from(y) + f64::from(dy)];
            let scale = expected[0].abs().max(expected[1].abs()).max(200.0);
            prop_assert!((found[0] - expected[0]).abs() < 1e-4 * scale, "{found:?} {expected:?}");
            prop_assert!((found[1] - expected[1]).abs() < 1e-4 * scale, "{found:?} {expected:?}");
            let seen = Reprojection::new(&a, &b, size).point(x as f32, y as f32, (1.0 / t) as f32);
            let ([to_x, to_y], near) = seen.unwrap();
            prop_assert!((to_x - x as f32 - dx).abs() < 1e-3 && (to_y - y as f32 - dy).abs() < 1e-3);
            prop_assert!((f64::from(near) * way.length() - 1.0).abs() < 1e-4, "{near} {}", way.length());
        }
    }

    proptest! {
        #[test]
        fn parallel_rays_meet_the_point_too(
            a in camera(), turn in -10.0f64..10.0, closer in 0.9f64..1.1, side in -0.1f64..0.1,
            x in 0u32..200, y in 0u32..100, t in 0.2f64..1.8,
        ) {
            let size = FrameSize::new(200, 100).unwrap();
            let a = Camera { projection: Projection::Orthographic, ..a };
            let eye = glam::DQuat::from_rotation_y(turn.to_radians()) * (a.eye * closer);
            let b = Camera { eye, target: DVec3::splat(side), ..a };
            let ray = a.rays(size).ray(x, y);
            let point = ray.origin + ray.direction * t;
            // All volumes lie around the centre, before the planes where rays begin.
            prop_assume!(point.length() < 0.9);
            let ([to_x, to_y], near) =
                Reprojection::new(&a, &b, size).point(x as f32, y as f32, (1.0 / t) as f32).unwrap();
            let [dx, dy] = Reprojection::new(&a, &b, size).motion(x as f32, y as f32, (1.0 / t) as f32);
            prop_assert!((to_x - x as f32 - dx).abs() < 1e-3 && (to_y - y as f32 - dy).abs() < 1e-3);
            // The ray of the pixel that was found passes through the point.
            let rays = b.rays(size);
            let [forward, right, up] = rays.axes();
            let (u, v) = ((f64::from(to_x) + 0.5) / 100.0 - 1.0, 1.0 - (f64::from(to_y) + 0.5) / 50.0);
            let met = rays.origin() + right * u + up * v + forward / f64::from(near);
            prop_assert!((met - point).length() < 1e-4, "{met} {point}");
        }
    }

    #[test]
    fn a_part_moves_as_the_whole() {
        let size = FrameSize::new(640, 360).unwrap();
        let cameras = [20.0, 23.0].map(|azimuth| Camera::on_sphere(azimuth, 10.0, 2.0, 40.0));
        let whole = Reprojection::new(&cameras[0], &cameras[1], size);
        let [a, b] = [whole.motion(213.0, 107.0, 0.5), whole.of_part(200, 100).motion(13.0, 7.0, 0.5)];
        assert!((a[0] - b[0]).abs() < 1e-3 && (a[1] - b[1]).abs() < 1e-3, "{a:?} {b:?}");
    }

    #[test]
    fn a_still_camera_moves_nothing_and_a_turning_one_also_the_infinitely_far() {
        let size = FrameSize::new(64, 36).unwrap();
        let camera = Camera::on_sphere(20.0, 10.0, 2.0, 40.0);
        let [dx, dy] = Reprojection::new(&camera, &camera, size).motion(13.0, 7.0, 0.5);
        assert!(dx.abs() < 1e-4 && dy.abs() < 1e-4);
        let turned = Camera { target: DVec3::new(0.1, 0.0, 0.0), ..camera };
        let [dx, _] = Reprojection::new(&camera, &turned, size).motion(13.0, 7.0, 0.0);
        assert!(dx.abs() > 0.5);
    }
}
