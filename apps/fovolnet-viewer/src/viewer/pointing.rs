//! Words on the point under the pointer.

use super::Viewer;
use crate::ui::slices::reading::reading;
use eframe::egui::Context;
use glam::DVec3;

impl Viewer {
    /// Sets the `words` for the status line.
    pub(super) fn point_at(&mut self, context: &Context, words: Option<String>) {
        if self.pointed != words {
            self.pointed = words;
            // The status line of this frame is drawn already.
            context.request_repaint();
        }
    }

    /// Voxel that the picture shows at its place `at`, as a continuous number, once it is known.
    pub(super) fn voxel_shown(&self, at: [f64; 2]) -> Option<DVec3> {
        let (opened, picture) = (self.opened.as_ref()?, self.picture.as_ref()?);
        let found = self.engine.point().filter(|found| found.at == at)?;
        let point = found.point.filter(|_| found.camera == picture.shown.camera)?;
        let grid = opened.volume.volume.grid();
        Some(grid.world_to_grid(opened.world().direction(point)) - 0.5)
    }

    /// Draws a ruler to the place `at` of the picture, while the ruler is in use.
    pub(super) fn measure_in_picture(&mut self, at: [f64; 2], is_pressed: bool) {
        let voxel = self.voxel_shown(at);
        let is_known = self.engine.point().is_some_and(|found| found.at == at);
        let rulers = &mut self.slices.rulers;
        if rulers.draws_in(None) {
            if let Some(voxel) = voxel {
                rulers.draw_to(voxel, None);
            }
            // The point of the last place comes after the button was released.
            if !is_pressed && is_known {
                rulers.end();
            }
        } else if let Some(voxel) = voxel.filter(|_| is_pressed && self.slices.measures) {
            rulers.begin(voxel, None);
        }
    }

    /// Words on what the picture shows at its place `at`.
    pub(super) fn words_on_picture(&self, at: [f64; 2]) -> Option<String> {
        reading(&self.opened.as_ref()?.volume, self.voxel_shown(at)?)
    }
}
