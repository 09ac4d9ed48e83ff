//! The input of a plan as a list of samples.

use crate::plan::{Accumulate, Blend, Bypass, HistoryConfidence, Join, Layer, Plan, Read, Spread, TensorId};

/// Tensor that joins the colours and the mask of the input of `plan`, if there is one.
pub(super) fn known(plan: &Plan) -> Option<TensorId> {
    let inputs = plan.inputs();
    plan.layers().iter().find_map(|layer| match layer {
        Layer::Join(Join { colour, weight, output })
            if *colour == inputs.colour && Some(*weight) == inputs.mask =>
        {
            Some(*output)
        }
        _ => None,
    })
}

/// Tensor that layers of `plan` can read as a list of samples, if any. `known` joins the colours and mask of the
/// input.
pub(super) fn sampled(plan: &Plan, known: Option<TensorId>) -> Option<TensorId> {
    let inputs = plan.inputs();
    match (known, inputs.mask) {
        (Some(known), _) => takes_samples(plan, known).then_some(known),
        (None, None) => is_read_by_convolutions(plan, inputs.colour).then_some(inputs.colour),
        (None, Some(_)) => None,
    }
}

/// Whether only convolutions read `id`, at its own resolution.
pub(super) fn is_read_by_convolutions(plan: &Plan, id: TensorId) -> bool {
    let is_read_alike = |layer: &Layer| match layer {
        Layer::Conv(conv) => conv.inputs.iter().all(|read| read.tensor != id || *read == Read::same(id)),
        _ => !layer.inputs().contains(&id),
    };
    let is_kept = plan.output() == id || plan.states().iter().any(|state| state.next == id);
    plan.layers().iter().all(is_read_alike) && !is_kept
}

/// Whether all readers of `known`, and of the colours and mask that it joins, accept a list of samples.
pub(super) fn takes_samples(plan: &Plan, known: TensorId) -> bool {
    let is_sampled =
        |id: TensorId| id == known || id == plan.inputs().colour || Some(id) == plan.inputs().mask;
    plan.layers().iter().all(|layer| match layer {
        Layer::Join(Join { colour, weight, .. }) if is_input(plan, *colour, *weight) => true,
        Layer::Bypass(Bypass { colour, mask, input, .. }) if is_input(plan, *colour, *mask) => {
            !is_sampled(*input)
        }
        Layer::Spread(Spread { known: id, .. })
        | Layer::Blend(Blend { known: id, .. })
        | Layer::HistoryConfidence(HistoryConfidence { known: id, .. })
        | Layer::Accumulate(Accumulate { known: id, .. })
            if *id == known =>
        {
            layer.inputs().into_iter().filter(|id| is_sampled(*id)).count() == 1
        }
        _ => !layer.inputs().into_iter().any(is_sampled),
    }) && !plan.states().iter().any(|state| is_sampled(state.next))
        && !is_sampled(plan.output())
}

/// Whether these are the colours and the mask of the input of `plan`.
pub fn is_input(plan: &Plan, colour: TensorId, mask: TensorId) -> bool {
    (colour, Some(mask)) == (plan.inputs().colour, plan.inputs().mask)
}
