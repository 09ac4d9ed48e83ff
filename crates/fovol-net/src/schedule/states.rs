//! Properties of states and of the output.

use crate::plan::{Activation, Clamp, Layer, Plan, Reproject, TensorId};

/// States that are points: inputs of reprojection layers.
pub(super) fn points(plan: &Plan) -> Vec<TensorId> {
    let moved = plan.layers().iter().filter_map(|layer| match layer {
        Layer::Reproject(Reproject { input, .. }) => Some(*input),
        _ => None,
    });
    moved.collect()
}

/// For each state of `plan`, whether its next value is finite for any input.
///
/// This holds for clamped pictures and for samples, which are clamped too. It also holds after convolutions with
/// ReLU, whose implementation turns infinite values and NaN into 0.
pub(super) fn stays_finite(plan: &Plan) -> Vec<bool> {
    let is_finite = |layer: &Layer| match layer {
        Layer::Clamp(_) | Layer::Accumulate(_) => true,
        Layer::Conv(conv) => conv.activation == Activation::Relu,
        _ => false,
    };
    let made = |id: TensorId| plan.layers().iter().find(|layer| layer.output() == id);
    plan.states().iter().map(|state| made(state.next).is_some_and(is_finite)).collect()
}

/// Tensor that is written to the frame.
pub(super) fn shown(plan: &Plan) -> TensorId {
    let cut = plan.layers().iter().find_map(|layer| match layer {
        Layer::Clamp(Clamp { input, output }) if *input == plan.output() => Some(*output),
        _ => None,
    });
    cut.filter(|cut| plan.states().iter().any(|state| state.next == *cut)).unwrap_or(plan.output())
}
