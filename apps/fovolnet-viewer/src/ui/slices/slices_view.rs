//! Layout of the slices beside the picture.

use super::orientation::{Lie, Plane};
use super::slice_view;
use super::slices_state::Slices;
use crate::session::opened::Opened;
use eframe::egui::{Rect, Ui, pos2};

/// Distance between the pictures, in points.
const GAP: f32 = 2.0;

/// Shows the three slices of `opened` in `rooms`. Returns the words on the voxel under the pointer.
pub fn show(ui: &mut Ui, slices: &mut Slices, opened: &Opened, rooms: [Rect; 3]) -> Option<String> {
    let placement = opened.volume.volume.placement().filter(|_| opened.world().is_patient());
    let lies = Plane::ALL.map(|plane| Lie::new(plane, placement));
    let mut words = None;
    for (which, room) in rooms.into_iter().enumerate() {
        words = slice_view::show(ui, slices, opened, (&lies, which), room).or(words);
    }
    words
}

/// Rooms of the 3-D picture, at the top right, and of the axial, coronal and sagittal slice.
pub fn rooms(whole: Rect) -> (Rect, [Rect; 3]) {
    let middle = whole.center().round();
    let half = 0.5 * GAP;
    let [top, bottom] = [[whole.top(), middle.y - half], [middle.y + half, whole.bottom()]];
    let [left, right] = [[whole.left(), middle.x - half], [middle.x + half, whole.right()]];
    let room = |[x0, x1]: [f32; 2], [y0, y1]: [f32; 2]| Rect::from_min_max(pos2(x0, y0), pos2(x1, y1));
    (room(right, top), [room(left, top), room(left, bottom), room(right, bottom)])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn four_pictures_fill_the_place_without_touching() {
        let whole = Rect::from_min_max(pos2(0.0, 10.0), pos2(200.0, 110.0));
        let (picture, slices) = rooms(whole);
        assert_eq!(picture, Rect::from_min_max(pos2(101.0, 10.0), pos2(200.0, 59.0)));
        assert_eq!(slices[1], Rect::from_min_max(pos2(0.0, 61.0), pos2(99.0, 110.0)));
        let all = [picture, slices[0], slices[1], slices[2]];
        for (i, a) in all.iter().enumerate() {
            assert!(whole.contains_rect(*a) && all[i + 1..].iter().all(|b| !a.intersects(*b)));
        }
    }
}
