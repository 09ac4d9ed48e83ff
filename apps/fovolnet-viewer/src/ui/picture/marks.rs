//! Overlays on the picture: bounding box, axes, scales and gaze.

use crate::ui::picture::navigation::visible_height;
use crate::ui::slices::ruler::unit_of_length;
use eframe::egui::{Align2, Color32, FontId, Mesh, Painter, Pos2, Rect, Shape, Stroke, Vec2, pos2, vec2};
use fovolnet::core::{Camera, Grid, TransferFunction};
use glam::DVec3;

/// Projection from the world to the screen.
#[derive(Debug, Clone, Copy)]
pub struct Projection {
    camera: Camera,
    rect: Rect,
}

impl Projection {
    /// Projection of a picture of `camera` that fills `rect`.
    pub fn new(camera: Camera, rect: Rect) -> Self {
        Self { camera, rect }
    }

    /// Forward, right and up of the camera.
    pub fn axes(&self) -> (DVec3, DVec3, DVec3) {
        self.camera.axes()
    }

    /// Screen position of `point`, or `None` behind the eye.
    pub fn project(&self, point: DVec3) -> Option<Pos2> {
        let (forward, right, up) = self.camera.axes();
        let seen = point - self.camera.eye;
        let depth = match self.camera.projection {
            fovolnet::core::Projection::Perspective => seen.dot(forward),
            fovolnet::core::Projection::Orthographic => (self.camera.target - self.camera.eye).length(),
        };
        if depth < 1e-3 {
            return None;
        }
        let scale = f64::from(self.rect.height()) / (2.0 * (self.camera.fovy.to_radians() * 0.5).tan());
        let [x, y] = [seen.dot(right), -seen.dot(up)].map(|along| (along / depth * scale) as f32);
        Some(self.rect.center() + vec2(x, y))
    }
}

/// Light line with a dark outline, visible on any background.
pub fn line(painter: &Painter, from: Pos2, to: Pos2, width: f32, colour: Color32) {
    painter.line_segment([from, to], Stroke::new(width + 1.5, Color32::from_black_alpha(110)));
    painter.line_segment([from, to], Stroke::new(width, colour));
}

/// Text with a dark outline.
pub fn label(painter: &Painter, at: Pos2, anchor: Align2, text: &str) {
    let font = FontId::proportional(12.0);
    for offset in [vec2(1.0, 0.0), vec2(-1.0, 0.0), vec2(0.0, 1.0), vec2(0.0, -1.0)] {
        painter.text(at + offset, anchor, text, font.clone(), Color32::from_black_alpha(160));
    }
    painter.text(at, anchor, text, font, Color32::WHITE);
}

/// Draws the edges of the box with these `corners` in the world. Bit a of a corner's index is its end along axis a.
pub fn bounding_box(painter: &Painter, projection: &Projection, corners: [DVec3; 8], colour: Color32) {
    for i in 0..8usize {
        for bit in 0..3 {
            if i >> bit & 1 == 1 {
                continue;
            }
            let ends = [corners[i], corners[i | 1 << bit]].map(|end| projection.project(end));
            if let [Some(from), Some(to)] = ends {
                painter.line_segment([from, to], Stroke::new(1.0, colour));
            }
        }
    }
}

/// Size of [`axes`] on the screen, in points.
pub const AXES: f32 = 64.0;

/// Labels of the ends of [`axes`]: x, y, z and −x, −y, −z. Empty labels are not drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AxisNames([&'static str; 6]);

impl AxisNames {
    /// Labels of grid axes.
    pub const GRID: Self = Self(["x", "y", "z", "", "", ""]);
    /// Labels of a patient's sides: left, superior, anterior, right, inferior, posterior.
    pub const PATIENT: Self = Self(["L", "S", "A", "R", "I", "P"]);
}

/// Draws the orientation of the world axes in the middle of `rect`. Returns the clickable ends with the directions to
/// look from.
pub fn axes(painter: &Painter, camera: &Camera, rect: Rect, names: AxisNames) -> [(Pos2, DVec3, [i8; 3]); 6] {
    let (forward, right, up) = camera.axes();
    let directions =
        [[1, 0, 0], [0, 1, 0], [0, 0, 1], [-1, 0, 0], [0, -1, 0], [0, 0, -1]].map(|direction: [i8; 3]| {
            let axis = DVec3::from_array(direction.map(f64::from));
            let way = vec2(axis.dot(right) as f32, -axis.dot(up) as f32) * (0.4 * rect.width());
            (rect.center() + way, axis, direction)
        });
    painter.circle_filled(rect.center(), 0.5 * rect.width(), Color32::from_black_alpha(70));
    let mut sorted = directions;
    sorted.sort_by(|a, b| b.1.dot(forward).total_cmp(&a.1.dot(forward)));
    for (end, _, direction) in sorted {
        let along = direction.map(i8::abs).iter().position(|&c| c == 1).unwrap_or(0);
        let colour = [
            Color32::from_rgb(235, 90, 80),
            Color32::from_rgb(110, 200, 90),
            Color32::from_rgb(90, 140, 245),
        ][along];
        let is_ahead = direction.iter().sum::<i8>() > 0;
        let name = names.0[if is_ahead { along } else { along + 3 }];
        let colour = if is_ahead { colour } else { colour.gamma_multiply(0.6) };
        if is_ahead {
            line(painter, rect.center(), end, 2.0, colour);
        }
        painter.circle_filled(end, if name.is_empty() { 3.5 } else { 7.0 }, colour);
        painter.text(end, Align2::CENTER_CENTER, name, FontId::proportional(11.0), Color32::BLACK);
    }
    directions
}

/// Largest round length up to `most`: 1, 2 or 5 times a power of ten.
fn round_length(most: f64) -> f64 {
    let power = 10f64.powf(most.log10().floor());
    [5.0, 2.0, 1.0].into_iter().map(|digit| digit * power).find(|&length| length <= most).unwrap_or(power)
}

/// Draws a scale bar for the distance of the target of `camera`, in the `units` of the volume's spacing.
pub fn scale_bar(painter: &Painter, camera: &Camera, grid: &Grid, units: Option<&str>, rect: Rect) {
    // In world units the longest side is 1; this is the world length of a unit of the file.
    let unit = grid.voxel_size().x / grid.spacing()[0];
    let points_a_unit = f64::from(rect.height()) / visible_height(camera) * unit;
    length_bar(painter, points_a_unit, unit_of_length(grid, units), rect);
}

/// Draws a bar of a round length at the bottom left of `rect`, where a `unit` has `points_a_unit`.
pub fn length_bar(painter: &Painter, points_a_unit: f64, unit: &str, rect: Rect) {
    let length = round_length(f64::from(rect.width().min(rect.height())) * 0.3 / points_a_unit);
    if !length.is_finite() || length <= 0.0 {
        return;
    }
    let points = (length * points_a_unit) as f32;
    let [from, to] =
        [rect.left_bottom() + vec2(14.0, -16.0), rect.left_bottom() + vec2(14.0 + points, -16.0)];
    line(painter, from, to, 2.0, Color32::WHITE);
    for end in [from, to] {
        line(painter, end - vec2(0.0, 4.0), end + vec2(0.0, 4.0), 2.0, Color32::WHITE);
    }
    label(
        painter,
        from.lerp(to, 0.5) - vec2(0.0, 5.0),
        Align2::CENTER_BOTTOM,
        &format!("{} {unit}", short(length)),
    );
}

/// Draws the colours of `transfer` over the `range` of the volume.
pub fn colour_bar(painter: &Painter, transfer: &TransferFunction, range: [f64; 2], rect: Rect) {
    let bar = Rect::from_min_size(
        rect.right_bottom() - vec2(30.0, 16.0 + 0.35 * rect.height()),
        vec2(12.0, 0.35 * rect.height()),
    );
    painter.rect_filled(bar.expand(1.5), 1.0, Color32::from_black_alpha(140));
    let steps = 48;
    let mut mesh = Mesh::default();
    for i in 0..steps {
        let [below, above] = [i, i + 1].map(|i| i as f32 / steps as f32);
        let [r, g, b, _] = transfer.evaluate(f64::from(below + above) * 0.5).map(|c| (c * 255.0) as u8);
        let piece = Rect::from_min_max(
            pos2(bar.left(), bar.bottom() - above * bar.height()),
            pos2(bar.right(), bar.bottom() - below * bar.height()),
        );
        mesh.add_colored_rect(piece, Color32::from_rgb(r, g, b));
    }
    painter.add(Shape::mesh(mesh));
    for (value, y) in
        [(range[1], bar.top()), (0.5 * (range[0] + range[1]), bar.center().y), (range[0], bar.bottom())]
    {
        label(painter, pos2(bar.left() - 5.0, y), Align2::RIGHT_CENTER, &short(value));
    }
}

/// Draws a ring at the gaze.
pub fn gaze(painter: &Painter, gaze: [f64; 2], sigma: f64, rect: Rect) {
    let centre = rect.min + vec2(gaze[0] as f32, gaze[1] as f32) * rect.size();
    let radius = (2.0 * sigma as f32 * rect.width()).max(6.0);
    painter.circle_stroke(centre, radius, Stroke::new(1.0, Color32::from_white_alpha(60)));
}

/// Formats a number in few characters.
pub fn short(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 || (0.01..1e5).contains(&size) {
        let digits = if size >= 100.0 || value == value.round() { 0 } else { 2 };
        format!("{value:.digits$}")
    } else {
        format!("{value:.1e}")
    }
}

/// Direction of `light` after a drag by `delta` points in the view of `camera`.
pub fn turned_light(light: DVec3, camera: &Camera, delta: Vec2) -> DVec3 {
    let (_, right, up) = camera.axes();
    let turned = light.normalize_or(DVec3::Y) + (right * f64::from(delta.x) - up * f64::from(delta.y)) * 0.01;
    turned.normalize_or(light)
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovolnet::core::FrameSize;

    #[test]
    fn points_are_where_their_rays_come_from() {
        let camera = Camera::on_sphere(40.0, 25.0, 1.9, 35.0);
        let size = FrameSize::new(160, 90).unwrap();
        let projection = Projection::new(camera, Rect::from_min_size(Pos2::ZERO, vec2(160.0, 90.0)));
        for (x, y) in [(3, 4), (80, 45), (150, 88)] {
            let ray = camera.rays(size).ray(x, y);
            let at = projection.project(ray.origin + ray.direction * 2.0).unwrap();
            assert!((at - pos2(x as f32 + 0.5, y as f32 + 0.5)).length() < 1e-3);
        }
        assert!(projection.project(camera.eye * 2.0).is_none());
        let parallel = Camera { projection: fovolnet::core::Projection::Orthographic, ..camera };
        let projection = Projection { camera: parallel, ..projection };
        for (x, y, away) in [(3, 4, 0.2), (150, 88, 1.7)] {
            let ray = parallel.rays(size).ray(x, y);
            let at = projection.project(ray.origin + ray.direction * away).unwrap();
            assert!((at - pos2(x as f32 + 0.5, y as f32 + 0.5)).length() < 1e-3);
        }
    }

    #[test]
    fn lengths_and_numbers_are_easily_read() {
        for (most, length) in [(7.3, 5.0), (4.9, 2.0), (1.0, 1.0), (0.07, 0.05), (320.0, 200.0)] {
            assert!((round_length(most) - length).abs() < 1e-12);
        }
        let written = [0.0, 0.25, 12.5, 255.0, 4095.0, 1.5e7, -3e-6].map(short);
        assert_eq!(written, ["0", "0.25", "12.50", "255", "4095", "1.5e7", "-3.0e-6"]);
    }
}
