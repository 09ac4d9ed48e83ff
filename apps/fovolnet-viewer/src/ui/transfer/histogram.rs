//! Histogram of a volume's values.

use eframe::egui::{Color32, Mesh, Painter, Rect, Shape, pos2};
use fovolnet::OpenVolume;

/// Histogram of values.
#[derive(Debug, Clone)]
pub struct Histogram {
    /// Logarithms of the counts, scaled to 0…1.
    heights: Vec<f32>,
    /// Displayed range of values.
    range: [f64; 2],
}

/// Number of bins.
const BINS: usize = 256;

impl Histogram {
    /// Histogram of the values of `volume`.
    pub fn new(volume: &OpenVolume) -> Self {
        let range = volume.volume.range();
        let counts = volume.volume.histogram(BINS, range);
        let most = counts.iter().copied().max().unwrap_or(0).max(1) as f32;
        let heights = counts.iter().map(|&count| (1.0 + count as f32).ln() / (1.0 + most).ln()).collect();
        Self { heights, range }
    }

    /// Displayed range of values.
    pub fn range(&self) -> [f64; 2] {
        self.range
    }

    /// Draws a bar for each bin.
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
