//! Schedules the layers of a plan: fusion, tensors that are never written, and lifetimes.

mod derived;
mod fused_steps;
mod fusion;
mod lifetimes;
mod samples;
mod states;

pub use derived::Derived;
pub use fused_steps::FusedStep;
pub use fusion::{Addition, Pairing};
pub use samples::is_input;

use crate::plan::{Layer, Plan, TensorId};
use derived::derived;
use fusion::{addition, changes, fades, pairs};
use lifetimes::{finished, reads_once};
use samples::{known, sampled};
use states::{points, shown, stays_finite};

/// Schedule of a plan, computed once for all frames.
#[derive(Debug)]
pub struct Schedule {
    /// For each layer, the tensors that no later layer reads.
    pub finished: Vec<Vec<TensorId>>,
    /// For each layer, how it can be fused with the next one, if it can.
    pub pairs: Vec<Option<Pairing>>,
    /// For each layer, the number of consecutive pointwise layers from it on that change one picture.
    pub changes: Vec<usize>,
    /// For each tensor that is never written because readers compute it from another tensor: that tensor and the
    /// transformation.
    pub derived: Vec<Option<(TensorId, Derived)>>,
    /// Tensor that joins the colours and the mask of the input, if the plan has one.
    pub known: Option<TensorId>,
    /// Tensor that layers read as a list of samples, if they can: the joined input, or the colours alone. Neither
    /// it nor the colours and mask that it joins are ever written.
    pub sampled: Option<TensorId>,
    /// For each predicted kernel to whose picture a prediction from the same features is added: the convolution
    /// that predicts it, and the layer that adds it. All of them run together.
    pub additions: Vec<Option<Addition>>,
    /// For each layer, whether it moves points that the next layer accumulates at once.
    pub fades: Vec<bool>,
    /// States that are points.
    pub points: Vec<TensorId>,
    /// For each state, whether its next value is finite for any input.
    pub stays_finite: Vec<bool>,
    /// Tensor that is written to the frame: the output, or its clamped copy, since frames are clamped anyway.
    pub shown: TensorId,
    /// Whether a layer or state needs [`Self::shown`] as a tensor too.
    pub keeps_shown: bool,
}

impl Schedule {
    /// Whether layer `number`, which is `layer`, may overwrite its input `id`.
    pub fn is_free(&self, number: usize, layer: &Layer, id: TensorId) -> bool {
        self.finished[number].contains(&id) && reads_once(layer, id)
    }

    /// Schedules `plan`. `halved` says which tensors are stored as bf16, and `is_way` which transformations readers
    /// can apply.
    pub fn new(plan: &Plan, halved: &[bool], is_way: impl Fn(Derived) -> bool) -> Self {
        let (derived, known, shown) = (derived(plan, is_way), known(plan), shown(plan));
        let finished = finished(plan, &derived, known, shown);
        let addition = |number: usize| addition(plan, &derived, &finished, number);
        Self {
            pairs: pairs(plan, &finished, halved),
            fades: fades(plan, &finished),
            changes: changes(plan, &finished),
            additions: (0..plan.layers().len()).map(addition).collect(),
            finished,
            derived,
            known,
            sampled: sampled(plan, known),
            points: points(plan),
            stays_finite: stays_finite(plan),
            shown,
            keeps_shown: plan.states().iter().any(|state| state.next == shown),
        }
    }

    /// Schedules `plan` without fusion: every tensor is written.
    pub fn layer_by_layer(plan: &Plan) -> Self {
        let derived = vec![None; plan.tensors().len()];
        let changes = plan.layers().iter().map(|layer| usize::from(layer.changed().is_some())).collect();
        let shown = plan.output();
        let finished = finished(plan, &derived, None, shown);
        let layers = plan.layers().len();
        let (pairs, additions, fades) = (vec![None; layers], vec![None; layers], vec![false; layers]);
        let (known, sampled) = (None, None);
        let (points, stays_finite) = (points(plan), stays_finite(plan));
        Self {
            finished,
            pairs,
            changes,
            derived,
            known,
            sampled,
            additions,
            fades,
            points,
            stays_finite,
            shown,
            keeps_shown: true,
        }
    }
}
