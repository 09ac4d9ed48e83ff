//! Exports predicted kernels.

use super::export::Exporter;
use super::graph::integer;
use crate::Result;
use crate::plan::{Filter, Normalisation, SQUARED_EPSILON, Taps};

impl Exporter<'_> {
    /// Adds a predicted kernel and its application to the images of `filter`.
    pub fn filter(&mut self, filter: &Filter) -> Result<String> {
        let weights = self.kernel(filter)?;
        let mut first = 0;
        let mut total: Option<String> = None;
        for &(read, taps) in &filter.images {
            let image = self.read(read);
            let weights = &weights[first..first + taps.count()];
            first += taps.count();
            for (shifted, weight) in self.shifted(&filter.name, &image, taps).iter().zip(weights) {
                let product =
                    self.graph.plain("Mul", &format!("{}.product", filter.name), &[shifted, weight]);
                total = Some(match total {
                    None => product,
                    Some(sum) => self.graph.plain("Add", &format!("{}.sum", filter.name), &[&sum, &product]),
                });
            }
        }
        Ok(total.unwrap_or_default())
    }

    /// Adds the prediction of kernels. Returns one value of one channel for each tap.
    fn kernel(&mut self, filter: &Filter) -> Result<Vec<String>> {
        let name = &filter.name;
        let features = self.value(filter.features);
        let outputs = filter.expand * filter.expand * filter.taps();
        let channels = [outputs, self.plan.tensor(filter.features).channels];
        let mut kernel = self.learned_conv(name, &features, channels, [1, 1], 0)?;
        if filter.expand == 2 {
            kernel = self.graph.depth_to_space(&format!("{name}.expanded"), &kernel);
        }
        let kernel = self.normalised(&format!("{name}.kernel"), &kernel, filter.normalisation);
        let names: Vec<String> = (0..filter.taps()).map(|tap| format!("{name}.tap.{tap}")).collect();
        Ok(self.graph.split(&kernel, &vec![1; filter.taps()], &names))
    }

    /// Normalises `weights` to a sum of 1 over the channels.
    fn normalised(&mut self, name: &str, weights: &str, normalisation: Normalisation) -> String {
        let graph = &mut self.graph;
        match normalisation {
            Normalisation::Softmax => graph.node("Softmax", name, &[weights], vec![integer("axis", 1)]),
            Normalisation::Squared => {
                let squares = graph.plain("Mul", &format!("{name}.squares"), &[weights, weights]);
                let epsilon = graph.scalar(SQUARED_EPSILON);
                let positive = graph.plain("Add", &format!("{name}.positive"), &[&squares, &epsilon]);
                let channels = graph.indices(&[1]);
                let total = graph.node(
                    "ReduceSum",
                    &format!("{name}.total"),
                    &[&positive, &channels],
                    vec![integer("keepdims", 1)],
                );
                graph.plain("Div", name, &[&positive, &total])
            }
        }
    }

    /// Shifts `image` by each of the `taps`, so that every pixel holds the value that this tap weighs.
    pub fn shifted(&mut self, name: &str, image: &str, taps: Taps) -> Vec<String> {
        if taps == Taps::Centre {
            return vec![image.to_owned()];
        }
        let graph = &mut self.graph;
        let padded = graph.padded(&format!("{name}.padded"), image, "constant");
        let axes = graph.indices(&[2, 3]);
        // Two rows and two columns are left out. Negative ends count from the end; the last window ends at the
        // border.
        let end = |start: i64| if start == 2 { i64::MAX } else { start - 2 };
        let windows = (0..9).map(|tap| [tap / 3, tap % 3]);
        windows
            .map(|[y, x]| {
                let (starts, ends) = (graph.indices(&[y, x]), graph.indices(&[end(y), end(x)]));
                graph.plain("Slice", &format!("{name}.shifted"), &[&padded, &starts, &ends, &axes])
            })
            .collect()
    }
}
