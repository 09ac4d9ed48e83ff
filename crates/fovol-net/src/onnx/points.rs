//! Exports the layers of points: samples of earlier frames, each with its offset within its pixel.

use super::export::Exporter;
use super::graph::{integer, integers, text};
use super::model::{DataType, TensorData};
use super::warp::{COLUMNS, ROWS};
use crate::plan::{Reproject, Splat, Taps};

/// Channels of points: premultiplied colour and weight, the weight alone, and the offset in the pixel.
const KNOWN: [i64; 4] = [0, 1, 2, 3];
const WEIGHT: [i64; 1] = [3];
pub const PLACES: [i64; 2] = [4, 5];

/// The points, of four candidates, that fall into a pixel: weighted colours, weights, and offsets times weights.
#[derive(Default)]
struct Met {
    known: Vec<String>,
    weights: Vec<String>,
    places: Vec<String>,
}

impl Exporter<'_> {
    /// Moves the points of `input` along the motion.
    pub fn reproject(&mut self, &Reproject { input, motion, output }: &Reproject) -> String {
        let name = self.name(output);
        let (input, motion) = (self.value(input), self.value(motion));
        let whole = self.graph.plain("Floor", &format!("{name}.whole"), &[&motion]);
        let part = self.graph.plain("Sub", &format!("{name}.part"), &[&motion, &whole]);
        let mut met = Met::default();
        for steps in [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]] {
            let steps = self.graph.constant(&[1, 2, 1, 1], TensorData::Floats(steps.to_vec()));
            let corner = self.graph.plain("Add", &format!("{name}.corner"), &[&whole, &steps]);
            let found = self.nearest_moved(&format!("{name}.found"), &input, &corner);
            let from = self.graph.plain("Sub", &format!("{name}.from"), &[&steps, &part]);
            self.meet(name, &found, &from, &mut met);
        }
        let known = self.graph.plain("Sum", &format!("{name}.sum"), &all(&met.known));
        let places = self.graph.plain("Sum", &format!("{name}.places"), &all(&met.places));
        let total = self.graph.plain("Sum", &format!("{name}.total"), &all(&met.weights));
        let largest = self.graph.plain("Max", &format!("{name}.largest"), &all(&met.weights));
        let [zero, one] = [0.0, 1.0].map(|value| self.graph.scalar(value));
        let is_met = self.graph.plain("Greater", &format!("{name}.is_met"), &[&total, &zero]);
        let divisor = self.graph.plain("Where", &format!("{name}.divisor"), &[&is_met, &total, &one]);
        let factor = self.graph.plain("Div", &format!("{name}.factor"), &[&largest, &divisor]);
        let known = self.graph.plain("Mul", &format!("{name}.known"), &[&known, &factor]);
        let places = self.graph.plain("Div", &format!("{name}.places"), &[&places, &divisor]);
        self.graph.concatenated(name, &[known, places])
    }

    /// Adds to `met` those of the points `found` that fall into this pixel. `from` is the way from this pixel's
    /// last position to the pixels of these points.
    fn meet(&mut self, name: &str, found: &str, from: &str, met: &mut Met) {
        let places = self.channels(&format!("{name}.place"), found, &PLACES);
        let weight = self.channels(&format!("{name}.weight"), found, &WEIGHT);
        let known = self.channels(&format!("{name}.colour"), found, &KNOWN);
        let graph = &mut self.graph;
        let places = graph.plain("Add", &format!("{name}.place"), &[&places, from]);
        let [low, high] = [-0.5, 0.5].map(|value| graph.scalar(value));
        let after = graph.plain("GreaterOrEqual", &format!("{name}.after"), &[&places, &low]);
        let before = graph.plain("Less", &format!("{name}.before"), &[&places, &high]);
        let within = graph.plain("And", &format!("{name}.within"), &[&after, &before]);
        let float = vec![integer("to", DataType::Float as i64)];
        let within = graph.node("Cast", &format!("{name}.within"), &[&within], float);
        let both = vec![integers("axes", &[1]), integer("keepdims", 1)];
        let within = graph.node("ReduceMin", &format!("{name}.within"), &[&within], both);
        let weight = graph.plain("Mul", &format!("{name}.weight"), &[&weight, &within]);
        met.known.push(graph.plain("Mul", &format!("{name}.known"), &[&known, &within]));
        met.places.push(graph.plain("Mul", &format!("{name}.places"), &[&places, &weight]));
        met.weights.push(weight);
    }

    /// Shifts `image` by `motion`, which has whole pixels; zero outside.
    fn nearest_moved(&mut self, name: &str, image: &str, motion: &str) -> String {
        let parts = self.graph.split(motion, &[1, 1], &[format!("{name}.dx"), format!("{name}.dy")]);
        let x = self.positions(&format!("{name}.x"), &parts[0], COLUMNS);
        let y = self.positions(&format!("{name}.y"), &parts[1], ROWS);
        let both = self.graph.concatenated(&format!("{name}.positions"), &[x, y]);
        let grid = self.graph.node("Transpose", name, &[&both], vec![integers("perm", &[0, 2, 3, 1])]);
        let attributes =
            vec![text("mode", "nearest"), text("padding_mode", "zeros"), integer("align_corners", 0)];
        self.graph.node("GridSample", name, &[image, &grid], attributes)
    }

    /// Resamples the points of `input` at pixel centres.
    pub fn splat(&mut self, &Splat { input, output }: &Splat) -> String {
        let name = self.name(output);
        let input = self.value(input);
        let weight = self.channels(&format!("{name}.weight"), &input, &WEIGHT);
        let [zero, one] = [0.0, 1.0].map(|value| self.graph.scalar(value));
        let is_known = self.graph.plain("Greater", &format!("{name}.is_known"), &[&weight, &zero]);
        let float = vec![integer("to", DataType::Float as i64)];
        let is_known = self.graph.node("Cast", &format!("{name}.is_known"), &[&is_known], float);
        let both = self.graph.concatenated(&format!("{name}.both"), &[input, is_known]);
        let (mut sums, mut shares) = (Vec::new(), Vec::new());
        for (at, from) in self.shifted(&format!("{name}.around"), &both, Taps::Around).into_iter().enumerate()
        {
            let steps = [at % 3, at / 3].map(|step| step as f32 - 1.0);
            let places = self.channels(&format!("{name}.places"), &from, &PLACES);
            let known = self.channels(&format!("{name}.known"), &from, &KNOWN);
            let is_known = self.channels(&format!("{name}.counts"), &from, &[6]);
            let graph = &mut self.graph;
            let steps = graph.constant(&[1, 2, 1, 1], TensorData::Floats(steps.to_vec()));
            let apart = graph.plain("Add", &format!("{name}.apart"), &[&places, &steps]);
            let apart = graph.plain("Abs", &format!("{name}.apart"), &[&apart]);
            let near = graph.complement(&format!("{name}.near"), &apart);
            let near = graph.plain("Relu", &format!("{name}.near"), &[&near]);
            let near = graph.split(&near, &[1, 1], &[format!("{name}.near_x"), format!("{name}.near_y")]);
            let share = graph.plain("Mul", &format!("{name}.share"), &[&near[0], &near[1]]);
            let share = graph.plain("Mul", &format!("{name}.share"), &[&share, &is_known]);
            sums.push(graph.plain("Mul", &format!("{name}.part"), &[&known, &share]));
            shares.push(share);
        }
        let sum = self.graph.plain("Sum", &format!("{name}.sum"), &all(&sums));
        let shares = self.graph.plain("Sum", &format!("{name}.shares"), &all(&shares));
        let divisor = self.graph.plain("Max", &format!("{name}.divisor"), &[&shares, &one]);
        self.graph.plain("Div", name, &[&sum, &divisor])
    }
}

fn all(parts: &[String]) -> Vec<&str> {
    parts.iter().map(String::as_str).collect()
}
