//! Exports the layers that fill frames from sampled pixels.

use super::export::Exporter;
use super::graph::{integer, integers};
use super::model::TensorData;
use super::points::PLACES;
use crate::plan::{
    Accumulate, Blend, CONFIDENCE_ALLOWED, CONFIDENCE_EPSILON, CONFIDENCE_SHARE, HistoryConfidence, POINT,
    Smooth, Spread, TensorId,
};

/// Lower limit of divisors.
const SMALLEST: f32 = 1e-8;

/// Weighted pixels: all four channels (premultiplied colours and weight), and the weight alone.
struct Known {
    both: String,
    weight: String,
}

/// Makes a separable kernel of `weights` along both axes, for each of `channels` channels.
fn squares<const N: usize>(weights: [f32; N], channels: usize) -> TensorData {
    let plane = weights.iter().flat_map(|a| weights.map(|b| a * b)).collect::<Vec<_>>();
    TensorData::Floats(plane.repeat(channels))
}

impl Exporter<'_> {
    /// Adds `known`, spread at half the resolution. With `base` it spreads the residuals and adds them.
    pub fn spread(&mut self, &Spread { known, base, levels, output }: &Spread) -> String {
        let name = self.name(output);
        let Some(base) = base else {
            let known = self.known_pixels(name, known);
            return self.pull_push(name, &known, levels, 1);
        };
        let (known, base) = (self.known(name, known), self.value(base));
        let doubled = self.graph.bilinear(&format!("{name}.up"), &base);
        let difference = self.difference(name, &known, &doubled);
        let both = self.graph.concatenated(&format!("{name}.beside"), &[difference, known.weight]);
        let correction = self.pull_push(name, &both, levels, 1);
        self.graph.plain("Add", name, &[&base, &correction])
    }

    /// Adds a smoothing by (1, 2, 1)/4 along both axes.
    pub fn smooth(&mut self, &Smooth { input, output }: &Smooth) -> String {
        let (name, channels) = (self.name(output), self.plan.tensor(input).channels);
        let input = self.value(input);
        let padded = self.graph.padded(&format!("{name}.padded"), &input, "edge");
        let kernel = self.graph.constant(&[channels, 1, 3, 3], squares([0.25, 0.5, 0.25], channels));
        self.graph.node("Conv", name, &[&padded, &kernel], vec![integer("group", channels as i64)])
    }

    /// Adds c + (1 − w) · up(`base`).
    pub fn blend(&mut self, &Blend { known, base, output }: &Blend) -> String {
        let name = self.name(output);
        let known = self.known(name, known);
        let colour = self.channels(&format!("{name}.colour"), &known.both, &[0, 1, 2]);
        let base = self.value(base);
        let base = self.graph.bilinear(&format!("{name}.up"), &base);
        let open = self.graph.complement(&format!("{name}.open"), &known.weight);
        let rest = self.graph.plain("Mul", &format!("{name}.rest"), &[&base, &open]);
        self.graph.plain("Add", name, &[&colour, &rest])
    }

    /// Adds the confidence in earlier frames: v / (v + share · max(e − allowed · v, 0)).
    pub fn history_confidence(&mut self, layer: &HistoryConfidence) -> String {
        let &HistoryConfidence { known, prior, fresh, levels, output } = layer;
        let (name, lowest) = (self.name(output), self.plan.tensor(output).level);
        let known = self.known(name, known);
        let prior = self.value(prior);
        let fresh = self.value(fresh);
        let fresh = self.graph.bilinear(&format!("{name}.up"), &fresh);
        let [error, own] = [prior, fresh].map(|expected| {
            let difference = self.difference(name, &known, &expected);
            let graph = &mut self.graph;
            let square = graph.plain("Mul", &format!("{name}.square"), &[&difference, &difference]);
            let mean = vec![integers("axes", &[1]), integer("keepdims", 1)];
            graph.node("ReduceMean", &format!("{name}.mean"), &[&square], mean)
        });
        let zero = self.graph.scalar(0.0);
        let nothing = self.graph.plain("Mul", &format!("{name}.nothing"), &[&known.weight, &zero]);
        let parts = [error, own, nothing, known.weight];
        let both = self.graph.concatenated(&format!("{name}.squares"), &parts);
        let squares = self.pull_push(name, &both, levels, lowest);
        let [error, own] = [(0, "error"), (1, "own")]
            .map(|(channel, part)| self.channels(&format!("{name}.{part}"), &squares, &[channel]));
        let graph = &mut self.graph;
        let [epsilon, share, allowed] =
            [CONFIDENCE_EPSILON, CONFIDENCE_SHARE, CONFIDENCE_ALLOWED].map(|value| graph.scalar(value));
        let own = graph.plain("Add", &format!("{name}.own"), &[&own, &epsilon]);
        let allowed = graph.plain("Mul", &format!("{name}.allowed"), &[&own, &allowed]);
        let more = graph.plain("Sub", &format!("{name}.more"), &[&error, &allowed]);
        let more = graph.plain("Relu", &format!("{name}.positive"), &[&more]);
        let more = graph.plain("Mul", &format!("{name}.counted"), &[&more, &share]);
        let both = graph.plain("Add", &format!("{name}.both"), &[&own, &more]);
        graph.plain("Div", name, &[&own, &both])
    }

    /// Adds `known` + (1 − w) · `fade` · up(share) · `before`.
    pub fn accumulate(&mut self, layer: &Accumulate) -> String {
        let &Accumulate { known, before, share, fade, output } = layer;
        let name = self.name(output);
        let Known { both, weight } = self.known(name, known);
        let open = self.graph.complement(&format!("{name}.open"), &weight);
        let places = (self.plan.tensor(before).channels == POINT).then(|| {
            let before = self.value(before);
            let places = self.channels(&format!("{name}.places"), &before, &PLACES);
            self.graph.plain("Mul", &format!("{name}.places"), &[&places, &open])
        });
        let mut before = self.known_pixels(name, before);
        if let Some(share) = share {
            let factor = 1 << self.plan.tensor(share).level;
            let share = self.value(share);
            let share = self.graph.bilinear_by(&format!("{name}.share"), &share, factor);
            before = self.graph.plain("Mul", &format!("{name}.believed"), &[&before, &share]);
        }
        let fade = self.graph.scalar(fade);
        let faded = self.graph.plain("Mul", &format!("{name}.faded"), &[&before, &fade]);
        let rest = self.graph.plain("Mul", &format!("{name}.rest"), &[&faded, &open]);
        let Some(places) = places else {
            return self.graph.plain("Add", name, &[&both, &rest]);
        };
        let sum = self.graph.plain("Add", &format!("{name}.known"), &[&both, &rest]);
        self.graph.concatenated(name, &[sum, places])
    }

    /// Selects channels of `value`.
    pub fn channels(&mut self, name: &str, value: &str, wanted: &[i64]) -> String {
        let wanted = self.graph.indices(wanted);
        self.graph.node("Gather", name, &[value, &wanted], vec![integer("axis", 1)])
    }

    /// Returns weighted pixels: the tensor itself, or the first four channels of points.
    fn known_pixels(&mut self, name: &str, known: TensorId) -> String {
        let value = self.value(known);
        match self.plan.tensor(known).channels {
            POINT => self.channels(&format!("{name}.points"), &value, &[0, 1, 2, 3]),
            _ => value,
        }
    }

    fn known(&mut self, name: &str, known: TensorId) -> Known {
        let both = self.known_pixels(name, known);
        let weight = self.channels(&format!("{name}.known"), &both, &[3]);
        Known { both, weight }
    }

    /// Computes c − w · picture: the residual of `picture` at weighted pixels.
    fn difference(&mut self, name: &str, known: &Known, picture: &str) -> String {
        let colour = self.channels(&format!("{name}.colour"), &known.both, &[0, 1, 2]);
        let graph = &mut self.graph;
        let expected = graph.plain("Mul", &format!("{name}.expected"), &[picture, &known.weight]);
        graph.plain("Sub", &format!("{name}.difference"), &[&colour, &expected])
    }

    /// Fills weighted pixels by pull-push, at 1/2^`lowest` of the resolution and with `levels` halvings.
    ///
    /// Pulling halves the resolution: values and weights w are averaged over 4×4 pixels by (1, 3, 3, 1)/8 along
    /// both axes and multiplied by min(8w, 1) / max(w, 1e-8). Pushing goes back: each finer level adds (1 − w) of
    /// the coarser one, bilinear. Finally values are divided by weights.
    fn pull_push(&mut self, name: &str, known: &str, levels: u32, lowest: u32) -> String {
        // The pyramid begins at half the resolution.
        let mut pyramid = vec![self.pulled(name, known)];
        for _ in 1..levels {
            let next = self.pulled(name, &pyramid[pyramid.len() - 1].both);
            pyramid.push(next);
        }
        let coarsest = pyramid.pop().map(|level| level.both).unwrap_or_default();
        let finer = pyramid[lowest as usize - 1..].iter().rev();
        let filled = finer.fold(coarsest, |coarser, finer| self.pushed(name, finer, &coarser));
        let sum = self.channels(&format!("{name}.sum"), &filled, &[0, 1, 2]);
        let total = self.channels(&format!("{name}.total"), &filled, &[3]);
        let smallest = self.graph.scalar(SMALLEST);
        let divisor = self.graph.plain("Max", &format!("{name}.divisor"), &[&total, &smallest]);
        self.graph.plain("Div", name, &[&sum, &divisor])
    }

    fn pulled(&mut self, name: &str, finer: &str) -> Known {
        let graph = &mut self.graph;
        let [gain, one, smallest] = [8.0, 1.0, SMALLEST].map(|value| graph.scalar(value));
        let padded = graph.padded(&format!("{name}.padded"), finer, "edge");
        let kernel = graph.constant(&[4, 1, 4, 4], squares([0.125, 0.375, 0.375, 0.125], 4));
        let attributes = vec![integers("strides", &[2; 2]), integer("group", 4)];
        let both = graph.node("Conv", &format!("{name}.means"), &[&padded, &kernel], attributes);
        let weight = graph.indices(&[3]);
        let along = vec![integer("axis", 1)];
        let mean = graph.node("Gather", &format!("{name}.mean"), &[&both, &weight], along);
        let sum = graph.plain("Mul", &format!("{name}.count"), &[&mean, &gain]);
        let weight = graph.plain("Min", &format!("{name}.weight"), &[&sum, &one]);
        let divisor = graph.plain("Max", &format!("{name}.divisor"), &[&mean, &smallest]);
        let factor = graph.plain("Div", &format!("{name}.factor"), &[&weight, &divisor]);
        let both = graph.plain("Mul", &format!("{name}.pulled"), &[&both, &factor]);
        Known { both, weight }
    }

    /// Pushes one level: `finer` + (1 − its weight) · `coarser`.
    fn pushed(&mut self, name: &str, finer: &Known, coarser: &str) -> String {
        let graph = &mut self.graph;
        let coarser = graph.bilinear(&format!("{name}.up"), coarser);
        let open = graph.complement(&format!("{name}.open"), &finer.weight);
        let rest = graph.plain("Mul", &format!("{name}.rest"), &[&coarser, &open]);
        graph.plain("Add", &format!("{name}.pushed"), &[&finer.both, &rest])
    }
}
