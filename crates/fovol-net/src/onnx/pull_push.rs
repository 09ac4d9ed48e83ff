//! Filling by averages of ever larger squares.

use super::export::Exporter;
use super::graph::{integer, integers};
use super::model::TensorData;
use crate::plan::TensorId;

/// Divisors are at least this.
const SMALLEST: f32 = 1e-8;

/// Four channels: premultiplied colours, and how far each pixel is known, 0…1; and the latter alone.
struct Known {
    both: String,
    weight: String,
}

/// (1, 3, 3, 1)/8 along both axes, for each of four channels.
fn binomial() -> Vec<f32> {
    let weights = [0.125f32, 0.375, 0.375, 0.125];
    let plane = weights.iter().flat_map(|a| weights.map(|b| a * b)).collect::<Vec<_>>();
    plane.repeat(4)
}

impl Exporter<'_> {
    /// `colour`, which is multiplied by `weight`: as it is where that is 1, and elsewhere mixed with what is around.
    ///
    /// Pulling halves the resolution `halvings` times: colours and weights w are averaged over 4×4 pixels by
    /// (1, 3, 3, 1)/8 along both axes and multiplied by min(8w, 1) / max(w, 1e-8). Pushing goes back: each finer level gets (1 − w) of the
    /// coarser, bilinear. At last colours are divided by weights.
    pub fn pull_push(&mut self, [colour, weight]: [TensorId; 2], halvings: u32, output: TensorId) -> String {
        let name = self.name(output);
        let mut levels = vec![self.known(name, colour, weight)];
        for _ in 0..halvings {
            let next = self.pulled(name, &levels[levels.len() - 1]);
            levels.push(next);
        }
        let coarsest = levels.pop().map(|level| level.both).unwrap_or_default();
        let filled = levels.iter().rev().fold(coarsest, |coarser, finer| self.pushed(name, finer, &coarser));
        self.divided(name, &filled)
    }

    fn known(&mut self, name: &str, colour: TensorId, weight: TensorId) -> Known {
        let (colour, weight) = (self.value(colour), self.value(weight));
        let both = self.graph.concatenated(&format!("{name}.known"), &[colour, weight.clone()]);
        Known { both, weight }
    }

    fn pulled(&mut self, name: &str, finer: &Known) -> Known {
        let graph = &mut self.graph;
        let [gain, one, smallest] = [8.0, 1.0, SMALLEST].map(|value| graph.scalar(value));
        let padded = graph.padded(&format!("{name}.padded"), &finer.both, "edge");
        let kernel = graph.constant(&[4, 1, 4, 4], TensorData::Floats(binomial()));
        let attributes = vec![integers("strides", &[2; 2]), integer("group", 4)];
        let both = graph.node("Conv", &format!("{name}.means"), &[&padded, &kernel], attributes);
        let weight = graph.indices(&[3]);
        let mean = graph.node("Gather", &format!("{name}.mean"), &[&both, &weight], vec![integer("axis", 1)]);
        let sum = graph.plain("Mul", &format!("{name}.count"), &[&mean, &gain]);
        let weight = graph.plain("Min", &format!("{name}.weight"), &[&sum, &one]);
        let divisor = graph.plain("Max", &format!("{name}.divisor"), &[&mean, &smallest]);
        let factor = graph.plain("Div", &format!("{name}.factor"), &[&weight, &divisor]);
        let both = graph.plain("Mul", &format!("{name}.pulled"), &[&both, &factor]);
        Known { both, weight }
    }

    /// `finer` + (1 − its weight) · `coarser`.
    fn pushed(&mut self, name: &str, finer: &Known, coarser: &str) -> String {
        let graph = &mut self.graph;
        let coarser = graph.bilinear(&format!("{name}.up"), coarser);
        let open = graph.complement(&format!("{name}.open"), &finer.weight);
        let rest = graph.plain("Mul", &format!("{name}.rest"), &[&coarser, &open]);
        graph.plain("Add", &format!("{name}.pushed"), &[&finer.both, &rest])
    }

    fn divided(&mut self, name: &str, known: &str) -> String {
        let names = [format!("{name}.colour"), format!("{name}.total")];
        let parts = self.graph.split(known, &[3, 1], &names);
        let smallest = self.graph.scalar(SMALLEST);
        let divisor = self.graph.plain("Max", &format!("{name}.divisor"), &[&parts[1], &smallest]);
        self.graph.plain("Div", name, &[&parts[0], &divisor])
    }
}
