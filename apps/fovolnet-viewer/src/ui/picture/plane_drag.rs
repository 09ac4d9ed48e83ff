//! Clip planes that are dragged in the picture.

use super::marks::Projection;
use eframe::egui::{Vec2, vec2};
use glam::DVec3;

/// Length of the arrow along a plane's normal, in world units.
pub const ARROW: f64 = 0.2;
/// Small way along which the projection is as good as straight, in world units.
const STEP: f64 = 0.01;
/// Smallest part of its length that a normal may have across the view, to be dragged along.
const ACROSS: f32 = 0.25;
/// Farthest that a plane can be from the middle: half the diagonal of a cube of side 1.
pub const FARTHEST: f64 = 0.87;

/// Plane `[nx, ny, nz, d]` of a session: n·x = d, in world space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DraggedPlane {
    normal: DVec3,
    /// Length of the normal in the session.
    length: f64,
    /// Distance from the middle along the normal, in world units.
    distance: f64,
}

impl DraggedPlane {
    /// Plane of the session; `None` for one without a normal.
    pub fn new([x, y, z, d]: [f64; 4]) -> Option<Self> {
        let normal = DVec3::new(x, y, z);
        let length = normal.length();
        let is_plane = length.is_finite() && length > 1e-12 && d.is_finite();
        is_plane.then(|| Self { normal: normal / length, length, distance: d / length })
    }

    /// The plane for the session.
    pub fn numbers(&self) -> [f64; 4] {
        let [x, y, z] = (self.normal * self.length).to_array();
        [x, y, z, self.distance * self.length]
    }

    /// Point of the plane nearest to the middle of the volume.
    pub fn disc(&self) -> DVec3 {
        self.normal * self.distance
    }

    /// Tip of the arrow along the normal.
    pub fn tip(&self) -> DVec3 {
        self.disc() + self.normal * ARROW
    }

    /// Plane whose disc was dragged by `delta` points: it moves along its normal. Where the normal points along the view,
    /// up is away from the eye.
    #[must_use]
    pub fn moved(&self, projection: &Projection, delta: Vec2) -> Self {
        let Some(scale) = self.points_a_unit(projection) else { return *self };
        let (forward, ..) = projection.axes();
        let mut along = self.points_along(projection, self.normal).unwrap_or(Vec2::ZERO);
        if along.length() < ACROSS * scale {
            along = vec2(0.0, -scale * self.normal.dot(forward).signum() as f32);
        }
        let way = f64::from(delta.dot(along) / along.length_sq());
        Self { distance: (self.distance + way).clamp(-FARTHEST, FARTHEST), ..*self }
    }

    /// Plane whose arrow's tip was dragged by `delta` points: it turns about the middle of the volume.
    #[must_use]
    pub fn turned(&self, projection: &Projection, delta: Vec2) -> Self {
        let Some(scale) = self.points_a_unit(projection) else { return *self };
        let (_, right, up) = projection.axes();
        let way = (right * f64::from(delta.x) - up * f64::from(delta.y)) / (f64::from(scale) * ARROW);
        Self { normal: (self.normal + way).normalize_or(self.normal), ..*self }
    }

    /// Points of a unit across the view at the disc; `None` behind the eye.
    fn points_a_unit(&self, projection: &Projection) -> Option<f32> {
        let (_, _, up) = projection.axes();
        self.points_along(projection, up).map(Vec2::length).filter(|scale| *scale > 0.0)
    }

    /// Points of a unit along `way` at the disc.
    fn points_along(&self, projection: &Projection, way: DVec3) -> Option<Vec2> {
        let from = projection.project(self.disc())?;
        let to = projection.project(self.disc() + way * STEP)?;
        Some((to - from) / STEP as f32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eframe::egui::{Pos2, Rect};
    use fovolnet::core::Camera;

    /// View from the front: +x is right, +y up.
    fn front() -> Projection {
        let camera = Camera::on_sphere(0.0, 0.0, 2.0, 35.0);
        Projection::new(camera, Rect::from_min_size(Pos2::ZERO, vec2(400.0, 300.0)))
    }

    #[test]
    fn discs_move_with_the_pointer() {
        let plane = DraggedPlane::new([2.0, 0.0, 0.0, 0.2]).unwrap();
        assert!(plane.disc() == DVec3::X * 0.1 && plane.tip().abs_diff_eq(DVec3::X * 0.3, 1e-12));
        let before = front().project(plane.disc()).unwrap();
        let moved = plane.moved(&front(), vec2(30.0, 12.0));
        let after = front().project(moved.disc()).unwrap();
        assert!((after - before - vec2(30.0, 0.0)).length() < 0.1, "{before} {after}");
        let [x, y, z, d] = moved.numbers();
        assert!((x, y, z) == (2.0, 0.0, 0.0) && d > 0.2, "normals keep their length");
        assert_eq!(plane.moved(&front(), vec2(1e6, 0.0)).disc(), DVec3::X * FARTHEST);
    }

    #[test]
    fn planes_that_face_the_eye_move_away_upwards() {
        for normal in [-1.0, 1.0] {
            let plane = DraggedPlane::new([0.0, 0.0, normal, 0.0]).unwrap();
            assert!(plane.moved(&front(), vec2(0.0, -20.0)).disc().z < -0.01);
        }
    }

    #[test]
    fn tips_are_pulled_sideways() {
        let plane = DraggedPlane::new([0.0, 0.0, -1.0, 0.1]).unwrap();
        let turned = plane.turned(&front(), vec2(15.0, 0.0));
        let [x, y, z, d] = turned.numbers();
        assert!(x > 0.1 && y.abs() < 1e-6 && z < 0.0 && (d - 0.1).abs() < 1e-12);
        assert!((DVec3::new(x, y, z).length() - 1.0).abs() < 1e-12);
        let up = plane.turned(&front(), vec2(0.0, -15.0));
        assert!(up.numbers()[1] > 0.1);
    }

    #[test]
    fn planes_without_a_normal_have_no_handle() {
        assert_eq!(DraggedPlane::new([0.0, 0.0, 0.0, 1.0]), None);
        assert_eq!(DraggedPlane::new([f64::NAN, 0.0, 1.0, 1.0]), None);
    }
}
