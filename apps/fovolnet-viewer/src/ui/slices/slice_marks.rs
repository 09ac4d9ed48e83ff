//! Marks over a slice: letters, crosshair, rulers and scale.

use super::orientation::{Lie, Plane};
use super::placed_slice::PlacedSlice;
use super::ruler::{Ruler, unit_of_length};
use crate::ui::picture::marks::{label, length_bar, line, short};
use eframe::egui::{Align2, Color32, FontId, Painter, Pos2, Rect, Stroke, pos2, vec2};
use fovolnet::core::Volume;
use glam::DVec3;

/// Colour of rulers.
pub const RULER: Color32 = Color32::from_rgb(120, 215, 255);
/// Half the gap of a crosshair, which leaves its voxel in sight, in points.
const GAP: f32 = 7.0;

/// Draws the slice's name and number at the top left of `room`.
pub fn title(painter: &Painter, lie: &Lie, number: usize, room: Rect) {
    let axis = ["x", "y", "z"][lie.across.axis];
    let text = match lie.name == axis {
        true => format!("{axis} {number}"),
        false => format!("{}  {axis} {number}", lie.name),
    };
    let at = room.left_top() + vec2(8.0, 6.0);
    let font = FontId::proportional(13.0);
    painter.text(at + vec2(1.0, 1.0), Align2::LEFT_TOP, &text, font.clone(), Color32::BLACK);
    painter.text(at, Align2::LEFT_TOP, text, font, lie.plane.colour());
}

/// Draws the letters of the patient's sides, or axes of the grid, at the edges of `room`.
pub fn edges(painter: &Painter, lie: &Lie, room: Rect) {
    let inner = room.shrink(6.0);
    let places = [
        (inner.left_center(), Align2::LEFT_CENTER),
        (inner.center_top(), Align2::CENTER_TOP),
        (inner.right_center(), Align2::RIGHT_CENTER),
        (inner.center_bottom(), Align2::CENTER_BOTTOM),
    ];
    for ((at, anchor), text) in places.into_iter().zip(lie.edges) {
        label(painter, at, anchor, text);
    }
}

/// Draws the lines in which the other two slices, through `voxel`, cut this one.
pub fn crosshair(painter: &Painter, placed: &PlacedSlice, lies: &[Lie; 3], voxel: [usize; 3]) {
    let at = placed.point(DVec3::from_array(voxel.map(|along| along as f64)));
    let rect = placed.rect;
    for other in lies.iter().filter(|other| other.plane != placed.lie.plane) {
        let colour = other.plane.colour().gamma_multiply(0.8);
        let pieces: [[Pos2; 2]; 2] = if other.across.axis == placed.lie.right.axis {
            [
                [pos2(at.x, rect.top()), pos2(at.x, at.y - GAP)],
                [pos2(at.x, at.y + GAP), pos2(at.x, rect.bottom())],
            ]
        } else {
            [
                [pos2(rect.left(), at.y), pos2(at.x - GAP, at.y)],
                [pos2(at.x + GAP, at.y), pos2(rect.right(), at.y)],
            ]
        };
        for [from, to] in pieces {
            // Near an edge a piece has no length.
            if (to.x - from.x) + (to.y - from.y) > 0.0 {
                painter.line_segment([from, to], Stroke::new(1.0, colour));
            }
        }
    }
}

/// Draws the length bar of a slice of `volume`.
pub fn scale(painter: &Painter, placed: &PlacedSlice, volume: &Volume, room: Rect) {
    length_bar(painter, placed.points_a_unit, unit_of_length(volume.grid(), volume.units()), room);
}

/// Draws the `rulers` that lie in slice `number` of `placed`.
pub fn rulers<'a>(
    painter: &Painter,
    placed: &PlacedSlice,
    number: usize,
    volume: &Volume,
    rulers: impl Iterator<Item = &'a Ruler>,
) {
    let is_here = |ruler: &&Ruler| lies_in(ruler, placed.lie.plane, placed.lie.across.axis, number);
    for ruler in rulers.filter(is_here) {
        self::ruler(painter, ruler.ends.map(|end| placed.point(end)), ruler.length(volume), volume);
    }
}

fn lies_in(ruler: &Ruler, plane: Plane, axis: usize, number: usize) -> bool {
    ruler.plane == Some(plane) && (ruler.ends[0][axis] - number as f64).abs() < 0.5
}

/// Draws a ruler of this `length` between two points of the screen.
pub fn ruler(painter: &Painter, [from, to]: [Pos2; 2], length: f64, volume: &Volume) {
    line(painter, from, to, 1.5, RULER);
    let across = (to - from).normalized().rot90() * 5.0;
    for end in [from, to] {
        line(painter, end - across, end + across, 1.5, RULER);
    }
    let unit = unit_of_length(volume.grid(), volume.units());
    // On the right of the line, on the side from which it leans away.
    let falls = (to.x - from.x) * (to.y - from.y) > 0.0;
    let (aside, anchor) =
        if falls { (vec2(7.0, -5.0), Align2::LEFT_BOTTOM) } else { (vec2(7.0, 5.0), Align2::LEFT_TOP) };
    label(painter, from.lerp(to, 0.5) + aside, anchor, &format!("{} {unit}", short(length)));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rulers_are_drawn_in_their_own_slice() {
        let ruler =
            Ruler { ends: [DVec3::new(1.0, 2.0, 7.0), DVec3::new(3.0, 2.0, 7.0)], plane: Some(Plane::Axial) };
        assert!(lies_in(&ruler, Plane::Axial, 2, 7));
        assert!(!lies_in(&ruler, Plane::Axial, 2, 8) && !lies_in(&ruler, Plane::Coronal, 1, 2));
    }
}
