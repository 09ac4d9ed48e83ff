//! State of the slices.

use super::orientation::Lie;
use super::ruler::Rulers;
use super::slice_textures::SliceTextures;
use super::value_window::ValueWindow;
use crate::session::opened::Opened;
use eframe::egui::{Context, TextureHandle};

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
}
