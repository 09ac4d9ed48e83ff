//! State of the slices, and their layout.

use super::orientation::{Lie, Plane};
use super::ruler::Rulers;
use super::slice_textures::SliceTextures;
use super::slice_view;
use super::value_window::ValueWindow;
use crate::session::opened::Opened;
use eframe::egui::{Context, Rect, TextureHandle, Ui, pos2};

/// Slices through one voxel, and what is measured in them.
#[derive(Default)]
pub struct Slices {
    /// Voxel in which the slices meet.
    pub crosshair: [usize; 3],
    /// Chosen window; `None` for the shown range of the volume.
    pub window: Option<ValueWindow>,
    /// Rulers.
    pub rulers: Rulers,
    /// Whether dragging measures a length.
    pub measures: bool,
    /// Part of a step of the wheel that is left over.
    pub(super) wheel: f32,
    /// Volume that all this is about.
    volume: Option<Identity>,
    textures: [SliceTextures; 3],
}

/// Volume as far as crosshair, window and rulers are about it. Time points of a file are one.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Identity {
    source: String,
    dims: [usize; 3],
    /// Array, channel and component.
    part: [usize; 3],
}

/// Distance between the pictures, in points.
const GAP: f32 = 2.0;

impl Slices {
    /// Begins in the middle of `opened`, if it is another volume than before.
    pub fn follow(&mut self, opened: &Opened) {
        let dims = opened.volume.volume.grid().dims();
        let contents = opened.volume.volume.contents();
        let part = [contents.array, contents.channel, contents.component];
        let volume = Some(Identity { source: opened.volume.source.clone(), dims, part });
        if self.volume != volume {
            let (crosshair, measures) = (dims.map(|dim| dim / 2), self.measures);
            *self = Self { crosshair, measures, volume, ..Self::default() };
        }
    }

    /// Window of the slices of `opened`.
    pub fn shown_window(&self, opened: &Opened) -> ValueWindow {
        self.window.unwrap_or_else(|| ValueWindow::over(opened.volume.volume.range()))
    }

    /// Changes window and level by a drag of `right` and `down` points.
    pub(super) fn drag_window(&mut self, opened: &Opened, right: f64, down: f64) {
        let usual = ValueWindow::over(opened.volume.volume.range());
        self.window = Some(self.shown_window(opened).dragged(right, down, usual));
    }

    /// Draws the texture of slice `which`.
    pub(super) fn draw(&mut self, context: &Context, opened: &Opened, which: usize, lie: Lie) {
        let (number, window) = (self.crosshair[lie.across.axis], self.shown_window(opened));
        self.textures[which].draw(context, opened, (lie, number), window);
    }

    /// Textures of slice `which`, the lowest first.
    pub(super) fn textures(&self, which: usize) -> impl Iterator<Item = &TextureHandle> {
        self.textures[which].iter()
    }

    /// Shows the three slices of `opened` in `rooms`. Returns the words on the voxel under the pointer.
    pub fn show(&mut self, ui: &mut Ui, opened: &Opened, rooms: [Rect; 3]) -> Option<String> {
        let placement = opened.volume.volume.placement().filter(|_| opened.world().is_patient());
        let lies = Plane::ALL.map(|plane| Lie::new(plane, placement));
        let mut words = None;
        for (which, room) in rooms.into_iter().enumerate() {
            words = slice_view::show(ui, self, opened, (&lies, which), room).or(words);
        }
        words
    }
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
