//! Signed distances: negative inside, zero on the surface, positive outside, in units of the cube.
//! After Quilez, "Distance functions" (<https://iquilezles.org/articles/distfunctions/>).

use glam::{Vec2, Vec3};

pub(super) fn sphere(p: Vec3, centre: Vec3, radius: f32) -> f32 {
    p.distance(centre) - radius
}

/// An ellipsoid; exact on the surface, nearly so around it.
pub(super) fn ellipsoid(p: Vec3, centre: Vec3, radii: Vec3) -> f32 {
    let q = (p - centre) / radii;
    let length = q.length();
    let slope = (q / radii).length();
    if slope > 0.0 { length * (length - 1.0) / slope } else { -radii.min_element() }
}

/// A box with edges of half length `half`, rounded by `round`.
pub(super) fn cuboid(p: Vec3, centre: Vec3, half: Vec3, round: f32) -> f32 {
    let q = (p - centre).abs() - half + round;
    q.max(Vec3::ZERO).length() + q.max_element().min(0.0) - round
}

/// A bar from `a` to `b` whose radius goes from `ra` to `rb`, with round ends.
pub(super) fn bar(p: Vec3, [a, b]: [Vec3; 2], [ra, rb]: [f32; 2]) -> f32 {
    let (along, from_a) = (b - a, p - a);
    let t = (from_a.dot(along) / along.length_squared().max(1e-12)).clamp(0.0, 1.0);
    (from_a - along * t).length() - (ra + (rb - ra) * t)
}

/// A cylinder along `axis` (0 x, 1 y, 2 z) with flat ends.
pub(super) fn cylinder(p: Vec3, centre: Vec3, axis: usize, radius: f32, half_length: f32) -> f32 {
    let q = p - centre;
    let across = Vec2::new(q[(axis + 1) % 3], q[(axis + 2) % 3]).length();
    let d = Vec2::new(across - radius, q[axis].abs() - half_length);
    d.max(Vec2::ZERO).length() + d.max_element().min(0.0)
}

/// A ring around `axis`.
pub(super) fn torus(p: Vec3, centre: Vec3, axis: usize, ring: f32, thickness: f32) -> f32 {
    let q = p - centre;
    let across = Vec2::new(q[(axis + 1) % 3], q[(axis + 2) % 3]).length();
    Vec2::new(across - ring, q[axis]).length() - thickness
}

/// Both shapes, joined by a fillet of about `k`.
pub(super) fn blend(a: f32, b: f32, k: f32) -> f32 {
    let h = (k - (a - b).abs()).max(0.0) / k;
    a.min(b) - h * h * k * 0.25
}

/// `a` without `b`.
pub(super) fn without(a: f32, b: f32) -> f32 {
    a.max(-b)
}

/// Mirrors `p` to non-negative x, for shapes that are symmetric in x.
pub(super) fn mirrored(p: Vec3) -> Vec3 {
    p.with_x(p.x.abs())
}

/// 0…1 between `low` and `high`, smooth at both ends.
pub(super) fn smoothstep(low: f32, high: f32, x: f32) -> f32 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// How a scanner sees shapes: each voxel averages what lies within its point spread.
#[derive(Clone, Copy)]
pub(super) struct Scanner {
    width: f32,
}

impl Scanner {
    /// A scanner whose edges are `width` wide, in units of the cube.
    pub fn new(width: f32) -> Self {
        Self { width }
    }

    /// Coverage of a voxel by the shape, 0…1, from the signed distance.
    pub fn share(self, distance: f32) -> f32 {
        smoothstep(0.5 * self.width, -0.5 * self.width, distance)
    }

    /// `value` with the shape at `distance` put in, filled with `material`.
    pub fn put(self, value: f32, distance: f32, material: f32) -> f32 {
        value + (material - value) * self.share(distance)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_are_negative_inside_and_exact_on_axes() {
        let o = Vec3::ZERO;
        assert_eq!(sphere(Vec3::X * 2.0, o, 0.5), 1.5);
        assert!(ellipsoid(Vec3::X * 0.3, o, Vec3::new(0.3, 0.2, 0.1)).abs() < 1e-6);
        assert!(ellipsoid(o, o, Vec3::new(0.3, 0.2, 0.1)) < 0.0);
        assert!((cuboid(Vec3::X, o, Vec3::splat(0.4), 0.1) - 0.6).abs() < 1e-6);
        assert!((cylinder(Vec3::Y, o, 1, 0.2, 0.25) - 0.75).abs() < 1e-6);
        assert!((torus(Vec3::X, o, 1, 0.5, 0.1) - 0.4).abs() < 1e-6);
        assert!((bar(Vec3::X * 2.0, [o, Vec3::X], [0.1, 0.2]) - 0.8).abs() < 1e-6);
        assert!(blend(0.1, 0.1, 0.2) < 0.1 && blend(0.1, 5.0, 0.2) == 0.1);
    }

    #[test]
    fn a_scanner_sees_half_of_what_lies_on_the_edge() {
        let scanner = Scanner::new(0.1);
        assert_eq!([-1.0, 0.0, 1.0].map(|d| scanner.put(10.0, d, 20.0)), [20.0, 15.0, 10.0]);
    }
}
