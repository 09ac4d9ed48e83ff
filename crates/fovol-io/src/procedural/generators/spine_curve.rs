use glam::Vec2;
use std::f32::consts::TAU;

/// The middle line of a body in a plane, from the nose to the tip of the tail.
pub(super) struct SpineCurve {
    points: Vec<Point>,
}

#[derive(Clone, Copy)]
struct Point {
    at: Vec2,
    /// The radius of the body there.
    radius: f32,
    /// Distance from the nose along the curve.
    along: f32,
}

/// Where a point of the plane lies with respect to the nearest stretch of the curve.
#[derive(Debug, Clone, Copy)]
pub(super) struct Beside {
    /// Distance from the nose along the curve.
    pub along: f32,
    /// Signed distance from the curve: positive towards the back.
    pub up: f32,
    /// The radius of the body there.
    pub radius: f32,
}

/// Points between two corners of the body.
const FINENESS: usize = 10;
/// Points of the curled tail.
const CURL_POINTS: usize = 110;

impl SpineCurve {
    /// A smooth curve through `corners` (x, y, radius), then `turns` clockwise turns of a tail that
    /// winds up around `centre` and ends as a point.
    pub fn new(corners: &[[f32; 3]], centre: Vec2, turns: f32) -> Self {
        let mut curve = Self { points: Vec::new() };
        for i in 0..corners.len() - 1 {
            for step in 0..FINENESS {
                let [x, y, radius] = between(corners, i, step as f32 / FINENESS as f32);
                curve.push(Vec2::new(x, y), radius);
            }
        }
        let [x, y, thick] = corners[corners.len() - 1];
        let arm = Vec2::new(x, y) - centre;
        for step in 0..=CURL_POINTS {
            let t = step as f32 / CURL_POINTS as f32;
            let turned = Vec2::from_angle(-t * turns * TAU).rotate(arm);
            curve.push(centre + turned * (1.0 - 0.86 * t), thick * (1.0 - t) + 0.008);
        }
        curve
    }

    fn push(&mut self, at: Vec2, radius: f32) {
        let along = self.points.last().map_or(0.0, |last| last.along + last.at.distance(at));
        self.points.push(Point { at, radius, along });
    }

    /// The nearest stretch by the distance to the body's surface.
    pub fn beside(&self, p: Vec2) -> Beside {
        let mut nearest = (f32::INFINITY, Beside { along: 0.0, up: 0.0, radius: 0.0 });
        for pair in self.points.windows(2) {
            let [a, b] = [pair[0], pair[1]];
            let stretch = b.at - a.at;
            let t = ((p - a.at).dot(stretch) / stretch.length_squared().max(1e-12)).clamp(0.0, 1.0);
            let offset = p - a.at.lerp(b.at, t);
            let radius = a.radius + (b.radius - a.radius) * t;
            let outside = offset.length() - radius;
            if outside < nearest.0 {
                let side = if stretch.perp_dot(offset) < 0.0 { -1.0 } else { 1.0 };
                let along = a.along + (b.along - a.along) * t;
                nearest = (outside, Beside { along, up: side * offset.length(), radius });
            }
        }
        nearest.1
    }
}

/// The Catmull–Rom spline between corners `i` and `i` + 1.
fn between(corners: &[[f32; 3]], i: usize, f: f32) -> [f32; 3] {
    let last = corners.len() - 1;
    let p = [corners[i.saturating_sub(1)], corners[i], corners[i + 1], corners[(i + 2).min(last)]];
    std::array::from_fn(|c| {
        let [a, b, d, e] = [p[0][c], p[1][c], p[2][c], p[3][c]];
        0.5 * (2.0 * b
            + f * ((d - a) + f * ((2.0 * a - 5.0 * b + 4.0 * d - e) + f * (3.0 * (b - d) + e - a))))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_know_their_side_and_place() {
        let corners = [[-1.0, 0.0, 0.1], [0.0, 0.0, 0.2], [1.0, 0.0, 0.1]];
        let curve = SpineCurve::new(&corners, Vec2::new(1.0, -0.5), 1.0);
        let above = curve.beside(Vec2::new(-0.5, 0.3));
        assert!((above.up - 0.3).abs() < 0.01 && (above.along - 0.5).abs() < 0.08, "{above:?}");
        assert!(curve.beside(Vec2::new(-0.5, -0.3)).up < 0.0);
    }
}
