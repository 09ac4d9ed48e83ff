//! Groups the layers of a network into steps that run together.

use super::Schedule;
use super::fusion::{Addition, Pairing};
use crate::plan::{Layer, Plan, TensorId};
use std::ops::Range;

/// A step: layers that run together.
#[derive(Debug, Clone)]
pub enum FusedStep {
    One(usize),
    /// This layer, a convolution, and the next one, which alone reads its output.
    Pair(usize, Pairing),
    /// This layer, which moves points, and the next one, which accumulates them.
    Points(usize),
    /// Layers that change one picture pointwise.
    Changes(Range<usize>),
    /// A predicted kernel, and the layers from `changes` on that change its picture pointwise.
    Filter {
        layers: Range<usize>,
        changes: usize,
    },
}

impl FusedStep {
    /// Indices of the layers in the plan.
    pub fn layers(&self) -> Range<usize> {
        match *self {
            Self::One(number) => number..number + 1,
            Self::Pair(number, _) | Self::Points(number) => number..number + 2,
            Self::Changes(ref layers) | Self::Filter { ref layers, .. } => layers.clone(),
        }
    }

    /// Index of the tensor that the last layer writes.
    pub fn written(&self, plan: &Plan) -> usize {
        plan.layers()[self.layers().end - 1].output().index()
    }

    /// Index of the input tensor whose buffer the output overwrites, if any.
    pub fn written_over(&self, plan: &Plan, schedule: &Schedule) -> Option<usize> {
        match self {
            Self::One(number) => {
                let layer = &plan.layers()[*number];
                layer.begins_as().filter(|id| schedule.is_free(*number, layer, *id)).map(TensorId::index)
            }
            Self::Filter { .. } | Self::Points(_) => None,
            Self::Pair(number, pairing) => match &plan.layers()[*number] {
                Layer::Conv(conv) => pairing.replaced.map(|input| conv.inputs[input].tensor.index()),
                _ => None,
            },
            Self::Changes(layers) => {
                let first = &plan.layers()[layers.start];
                let changed = first.changed()?;
                schedule.is_free(layers.start, first, changed).then(|| changed.index())
            }
        }
    }
}

/// Tensors of up to this many elements stay in the processor's caches, so fusing two convolutions gains nothing.
const SMALL: usize = 1 << 20;

impl Schedule {
    /// Lists the steps of `plan` in order. `numbers` gives the number of elements of a tensor, by index.
    pub fn fused_steps(&self, plan: &Plan, numbers: impl Fn(usize) -> usize) -> Vec<FusedStep> {
        let mut units = Vec::new();
        let mut number = 0;
        while number < plan.layers().len() {
            let first = plan.layers()[number].output();
            if self.derived[first.index()].is_some() || self.sampled == Some(first) {
                number += 1;
                continue;
            }
            let pairing = self.pairs[number].filter(|_| numbers(first.index()) > SMALL);
            let unit = match (&plan.layers()[number], pairing, self.changes[number]) {
                (Layer::Filter(_), ..) => self.filter_unit(plan, number),
                (_, Some(pairing), _) => FusedStep::Pair(number, pairing),
                (Layer::Reproject(_), ..) if self.fades[number] => FusedStep::Points(number),
                (_, None, 0) => FusedStep::One(number),
                (_, None, count) => FusedStep::Changes(number..number + count),
            };
            number = unit.layers().end;
            units.push(unit);
        }
        units
    }

    /// Makes the step of the predicted kernel in layer `number`, with the pointwise layers that follow.
    fn filter_unit(&self, plan: &Plan, number: usize) -> FusedStep {
        if let Some(Addition { added, .. }) = self.additions[number] {
            return FusedStep::Filter { layers: number..added + self.changes[added], changes: added + 1 };
        }
        let (out, next) = (plan.layers()[number].output(), number + 1);
        let goes_on = plan
            .layers()
            .get(next)
            .is_some_and(|layer| layer.changed() == Some(out) && self.is_free(next, layer, out));
        let count = if goes_on { self.changes[next] } else { 0 };
        FusedStep::Filter { layers: number..next + count, changes: next }
    }
}
