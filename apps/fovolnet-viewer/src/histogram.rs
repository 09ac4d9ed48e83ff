//! How the values of a volume are distributed.

use eframe::egui::{Color32, Mesh, Painter, Rect, Shape, pos2};
use fovolnet::OpenVolume;

/// How values are distributed, and what they are.
#[derive(Debug, Clone)]
pub struct Histogram {
    /// The logarithm of how often values come, 0 to 1.
    heights: Vec<f32>,
    /// Values shown as 0 and 1.
    range: [f64; 2],
}

/// Bars of a histogram.
const BINS: usize = 256;

impl Histogram {
    /// Of the values of `volume`.
    pub fn new(volume: &OpenVolume) -> Self {
        let range = volume.volume.range();
        let counts = volume.volume.histogram(BINS, range);
        let most = counts.iter().copied().max().unwrap_or(0).max(1) as f32;
        let heights = counts.iter().map(|&count| (1.0 + count as f32).ln() / (1.0 + most).ln()).collect();
        Self { heights, range }
    }

    /// Values shown as 0 and 1.
    pub fn range(&self) -> [f64; 2] {
        self.range
    }

    /// Draws a bar for each value.
    pub(crate) fn paint(&self, painter: &Painter, plot: Rect, fill: Color32) {
        let width = plot.width() / self.heights.len() as f32;
        let mut mesh = Mesh::default();
        for (i, &height) in self.heights.iter().enumerate() {
            let left = plot.left() + i as f32 * width;
            let top = plot.bottom() - height * plot.height();
            let bar = Rect::from_min_max(pos2(left, top), pos2(left + width, plot.bottom()));
            mesh.add_colored_rect(bar, fill);
        }
        painter.add(Shape::mesh(mesh));
    }
}
