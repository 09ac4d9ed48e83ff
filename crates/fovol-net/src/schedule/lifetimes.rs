//! Last reads of tensors.

use super::derived::Derived;
use super::samples::is_input;
use crate::plan::{Bypass, Layer, Plan, TensorId};

/// Inputs of `layer`, with `known` in place of the colours and mask that it joins.
fn reads(plan: &Plan, layer: &Layer, known: Option<TensorId>) -> Vec<TensorId> {
    match (layer, known) {
        (Layer::Bypass(Bypass { colour, mask, input, .. }), Some(known))
            if is_input(plan, *colour, *mask) =>
        {
            vec![known, *input]
        }
        _ => layer.inputs(),
    }
}

/// For each layer of `plan`, the tensors that it reads for the last time. Tensors that are `derived` do not count.
pub(super) fn finished(
    plan: &Plan,
    derived: &[Option<(TensorId, Derived)>],
    known: Option<TensorId>,
    shown: TensorId,
) -> Vec<Vec<TensorId>> {
    let mut last = vec![None; plan.tensors().len()];
    for (number, layer) in plan.layers().iter().enumerate() {
        if derived[layer.output().index()].is_none() {
            let read = reads(plan, layer, known);
            let read = read.into_iter().map(|id| derived[id.index()].map_or(id, |(from, _)| from));
            read.for_each(|id| last[id.index()] = Some(number));
        }
    }
    for id in plan.states().iter().map(|state| state.next).chain([shown]) {
        last[id.index()] = None;
    }
    let mut finished = vec![Vec::new(); plan.layers().len()];
    for (at, number) in last.into_iter().enumerate() {
        if let Some(number) = number {
            finished[number].push(TensorId(at));
        }
    }
    finished
}

/// Whether exactly one input of `layer` is `id`.
pub(super) fn reads_once(layer: &Layer, id: TensorId) -> bool {
    layer.inputs().into_iter().filter(|read| *read == id).count() == 1
}
