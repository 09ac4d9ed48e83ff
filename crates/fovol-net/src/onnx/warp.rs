//! Exports reprojection along the motion.

use super::export::Exporter;
use super::graph::{integer, integers, text};
use super::model::DataType;
use crate::plan::{TensorId, Warp};

/// Axes of an image tensor \[1, channels, rows, columns\].
pub const ROWS: i64 = 2;
pub const COLUMNS: i64 = 3;

impl Exporter<'_> {
    /// Samples `input` where each pixel was in the last frame; bilinear, zero outside.
    pub fn warp(&mut self, &Warp { input, motion, output }: &Warp) -> String {
        let level = self.plan.tensor(input).level;
        let grid = match self.grids.get(&level) {
            Some(grid) => grid.clone(),
            None => {
                let grid = self.grid(motion, level);
                self.grids.insert(level, grid.clone());
                grid
            }
        };
        let attributes =
            vec![text("mode", "bilinear"), text("padding_mode", "zeros"), integer("align_corners", 0)];
        self.graph.node("GridSample", self.name(output), &[&self.value(input), &grid], attributes)
    }

    /// Computes where the pixels of `level` were, \[1, rows, columns, 2\], from −1 at the first border to 1 at the
    /// last.
    fn grid(&mut self, motion: TensorId, level: u32) -> String {
        let name = format!("grid.{}", 1 << level);
        let motion = self.scaled_motion(&name, motion, level);
        let parts = self.graph.split(&motion, &[1, 1], &[format!("{name}.dx"), format!("{name}.dy")]);
        let x = self.positions(&format!("{name}.x"), &parts[0], COLUMNS);
        let y = self.positions(&format!("{name}.y"), &parts[1], ROWS);
        let both = self.graph.concatenated(&format!("{name}.positions"), &[x, y]);
        self.graph.node("Transpose", &name, &[&both], vec![integers("perm", &[0, 2, 3, 1])])
    }

    /// Averages the motion over the frame's pixels within each pixel of `level`, and scales it to pixels of
    /// `level`.
    fn scaled_motion(&mut self, name: &str, motion: TensorId, level: u32) -> String {
        let motion = self.value(motion);
        if level == 0 {
            return motion;
        }
        let edge = 1i64 << level;
        let mean = self.graph.pooled(&format!("{name}.mean"), &motion, edge);
        let factor = self.graph.scalar(1.0 / edge as f32);
        self.graph.plain("Mul", &format!("{name}.motion"), &[&mean, &factor])
    }

    /// Computes (pixel centre + `motion`) · 2 / length − 1 along `axis`.
    pub fn positions(&mut self, name: &str, motion: &str, axis: i64) -> String {
        let graph = &mut self.graph;
        let [zero, one, at] = [0, 1, axis].map(|value| graph.index(value));
        let [half, unit, two] = [0.5, 1.0, 2.0].map(|value| graph.scalar(value));
        let shape = graph.plain("Shape", &format!("{name}.shape"), &[motion]);
        let count = graph.plain("Gather", &format!("{name}.count"), &[&shape, &at]);
        let pixels = graph.plain("Range", &format!("{name}.pixels"), &[&zero, &count, &one]);
        let float = || vec![integer("to", DataType::Float as i64)];
        let pixels = graph.node("Cast", &format!("{name}.pixels"), &[&pixels], float());
        let mut centres = graph.plain("Add", &format!("{name}.centres"), &[&pixels, &half]);
        if axis == ROWS {
            let column = graph.indices(&[-1, 1]);
            centres = graph.plain("Reshape", &format!("{name}.centres"), &[&centres, &column]);
        }
        let length = graph.node("Cast", &format!("{name}.length"), &[&count], float());
        let step = graph.plain("Div", &format!("{name}.step"), &[&two, &length]);
        let previous = graph.plain("Add", &format!("{name}.previous"), &[motion, &centres]);
        let scaled = graph.plain("Mul", &format!("{name}.scaled"), &[&previous, &step]);
        graph.plain("Sub", name, &[&scaled, &unit])
    }
}
