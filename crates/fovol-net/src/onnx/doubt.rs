//! How far what was known before is believed.

use super::export::Exporter;
use super::graph::{integer, integers};
use crate::plan::{DOUBT_EPSILON, DOUBT_SHARE, TensorId};

impl Exporter<'_> {
    /// For each sample the mean square by which it differs from `prior`, that by which it differs from the means of
    /// squares of `fresh`, and 0.
    pub fn doubt(
        &mut self,
        [colour, mask, fresh, prior]: [TensorId; 4],
        halvings: u32,
        output: TensorId,
    ) -> String {
        let name = self.name(output);
        let [colour, mask, fresh, prior] = [colour, mask, fresh, prior].map(|id| self.value(id));
        let mut around = self.graph.pooled(&format!("{name}.means"), &fresh, 1 << halvings);
        for _ in 0..halvings {
            around = self.graph.nearest(&format!("{name}.around"), &around);
        }
        let [error, variance] = [("error", prior), ("variance", around)].map(|(part, expected)| {
            let graph = &mut self.graph;
            let difference = graph.plain("Sub", &format!("{name}.{part}"), &[&colour, &expected]);
            let square = graph.plain("Mul", &format!("{name}.{part}.square"), &[&difference, &difference]);
            let mean = vec![integers("axes", &[1]), integer("keepdims", 1)];
            let mean = graph.node("ReduceMean", &format!("{name}.{part}.mean"), &[&square], mean);
            graph.plain("Mul", &format!("{name}.{part}.sampled"), &[&mean, &mask])
        });
        let share = self.share(name, &mask, halvings);
        let variance = self.graph.plain("Mul", &format!("{name}.known"), &[&variance, &share]);
        let zero = self.graph.scalar(0.0);
        let nothing = self.graph.plain("Mul", &format!("{name}.nothing"), &[&mask, &zero]);
        self.graph.concatenated(name, &[error, variance, nothing])
    }

    /// 2 / max(samples in the square, 2).
    fn share(&mut self, name: &str, mask: &str, halvings: u32) -> String {
        let graph = &mut self.graph;
        let [pixels, two] = [(1 << (2 * halvings)) as f32, 2.0].map(|value| graph.scalar(value));
        let density = graph.pooled(&format!("{name}.density"), mask, 1 << halvings);
        let count = graph.plain("Mul", &format!("{name}.count"), &[&density, &pixels]);
        let count = graph.plain("Max", &format!("{name}.most"), &[&count, &two]);
        let mut share = graph.plain("Div", &format!("{name}.share"), &[&two, &count]);
        for _ in 0..halvings {
            share = graph.nearest(&format!("{name}.shares"), &share);
        }
        share
    }

    /// `input` · v / (v + share · e).
    pub fn trust(&mut self, input: TensorId, doubts: TensorId, output: TensorId) -> String {
        let name = self.name(output);
        let (input, doubts) = (self.value(input), self.value(doubts));
        let graph = &mut self.graph;
        let [epsilon, share] = [DOUBT_EPSILON, DOUBT_SHARE].map(|value| graph.scalar(value));
        let [error, variance] = [(0, "error"), (1, "variance")].map(|(channel, part)| {
            let index = graph.indices(&[channel]);
            graph.node("Gather", &format!("{name}.{part}"), &[&doubts, &index], vec![integer("axis", 1)])
        });
        let variance = graph.plain("Add", &format!("{name}.variance"), &[&variance, &epsilon]);
        let error = graph.plain("Mul", &format!("{name}.error"), &[&error, &share]);
        let sum = graph.plain("Add", &format!("{name}.sum"), &[&variance, &error]);
        let believed = graph.plain("Div", &format!("{name}.share"), &[&variance, &sum]);
        graph.plain("Mul", name, &[&input, &believed])
    }
}
