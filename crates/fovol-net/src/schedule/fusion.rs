//! Layers that run together.

use super::derived::Derived;
use super::lifetimes::reads_once;
use crate::plan::{Activation, Add, Layer, Plan, Read, Reproject, TensorId};

/// An addition to a filtered picture.
#[derive(Debug, Clone, Copy)]
pub struct Addition {
    /// Layer that predicts the addend.
    pub predicted: usize,
    /// Layer that adds it.
    pub added: usize,
}

/// Fusion of two convolutions, of which the second alone reads the output of the first.
#[derive(Debug, Clone, Copy)]
pub struct Pairing {
    /// Input of the first convolution that the output of the second may overwrite: it has the same shape, and no
    /// later layer reads it.
    pub replaced: Option<usize>,
}

/// Finds the addition to the picture of layer `number`, if that is a predicted kernel and the addend is predicted
/// from the same features.
pub(super) fn addition(
    plan: &Plan,
    derived: &[Option<(TensorId, Derived)>],
    finished: &[Vec<TensorId>],
    number: usize,
) -> Option<Addition> {
    let layers = plan.layers();
    let Layer::Filter(filter) = &layers[number] else { return None };
    let predicted = number + 1;
    let Layer::Conv(conv) = layers.get(predicted)? else { return None };
    let is_alike = conv.inputs[..] == [Read::same(filter.features)]
        && (conv.size, conv.stride, conv.activation) == (1, 1, Activation::None);
    let unfolds = |id: TensorId| derived[id.index()] == Some((conv.output, Derived::Unfolded));
    let is_there = |layer: &Layer| derived[layer.output().index()].is_none();
    let added = (predicted + 1..layers.len()).find(|&at| is_there(&layers[at]))?;
    let Layer::Add(Add { input, more, .. }) = layers[added] else { return None };
    let is_of_pixels = if filter.expand == 1 { more == conv.output } else { unfolds(more) };
    let is_all = finished[added].contains(&filter.output) && finished[added].contains(&conv.output);
    (is_alike && is_of_pixels && input == filter.output && is_all).then_some(Addition { predicted, added })
}

/// For each layer of `plan`, the number of consecutive pointwise layers from it on whose intermediate results
/// nothing else reads.
pub(super) fn changes(plan: &Plan, finished: &[Vec<TensorId>]) -> Vec<usize> {
    let layers = plan.layers();
    let mut changes = vec![0; layers.len()];
    for (number, layer) in layers.iter().enumerate().rev() {
        let out = layer.output();
        let goes_on = layers.get(number + 1).is_some_and(|next| {
            next.changed() == Some(out) && reads_once(next, out) && finished[number + 1].contains(&out)
        });
        if layer.changed().is_some() {
            changes[number] = 1 + if goes_on { changes[number + 1] } else { 0 };
        }
    }
    changes
}

/// For each layer of `plan`, whether it moves points that only the next layer reads, and accumulates.
pub(super) fn fades(plan: &Plan, finished: &[Vec<TensorId>]) -> Vec<bool> {
    let layers = plan.layers();
    let fades = |number: usize| match (&layers[number], layers.get(number + 1)) {
        (Layer::Reproject(Reproject { output, .. }), Some(next @ Layer::Accumulate(_))) => {
            next.begins_as() == Some(*output) && finished[number + 1].contains(output)
        }
        _ => false,
    };
    (0..layers.len()).map(fades).collect()
}

/// For each layer of `plan`, how it can be fused with the next one, if both are 3×3 convolutions.
pub(super) fn pairs(plan: &Plan, finished: &[Vec<TensorId>], halved: &[bool]) -> Vec<Option<Pairing>> {
    let layers = plan.layers();
    let pair = |number: usize| {
        let (Layer::Conv(first), Layer::Conv(second)) = (&layers[number], layers.get(number + 1)?) else {
            return None;
        };
        let is_read_by_second = second.inputs[..] == [Read::same(first.output)];
        let is_read_by_others = !finished[number + 1].contains(&first.output);
        let is_plain = [first, second].iter().all(|conv| conv.stride == 1 && conv.size == 3);
        if !is_read_by_second || is_read_by_others || !is_plain {
            return None;
        }
        let (to, halved) = (plan.tensor(second.output), |id: TensorId| halved[id.index()]);
        let replaced = first.inputs.iter().position(|read| {
            let from = plan.tensor(read.tensor);
            let is_alike = (from.channels, from.level) == (to.channels, to.level)
                && halved(read.tensor) == halved(second.output);
            let is_free = finished[number].contains(&read.tensor) && reads_once(&layers[number], read.tensor);
            *read == Read::same(read.tensor) && is_alike && is_free
        });
        Some(Pairing { replaced })
    };
    (0..layers.len()).map(pair).collect()
}
