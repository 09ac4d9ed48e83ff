//! Schedules the layers of a plan: fusion, tensors that are never written, and lifetimes.

use crate::plan::{Activation, Layer, Plan, Read, TensorId};

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

/// Transformation by which a tensor is computed from another one during reading.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Derived {
    /// 2×2 pixels are folded into one with four times the channels.
    Folded,
    /// Channels are unfolded into 2×2 pixels.
    Unfolded,
    /// 2×2 pixels are averaged.
    Pooled,
    /// The channel of this number is taken.
    Channel(usize),
    /// 2×2 pixels of the channel of this number are folded into one pixel of four channels.
    FoldedChannel(usize),
}

impl Derived {
    /// Source tensor and transformation of the output of `layer`, if it is such a transformation.
    fn of(plan: &Plan, layer: &Layer) -> Option<(TensorId, Self)> {
        match layer {
            Layer::SpaceToDepth { input, .. } => Some((*input, Self::Folded)),
            Layer::DepthToSpace { input, .. } => Some((*input, Self::Unfolded)),
            Layer::Pool { input, .. } => Some((*input, Self::Pooled)),
            Layer::Part { input, first, output } if plan.tensor(*output).channels == 1 => {
                Some((*input, Self::Channel(*first)))
            }
            _ => None,
        }
    }

    /// Combines this transformation of `from` with the one `before` by which `from` is computed. `None` if `from`
    /// has to be written.
    fn after(self, before: Option<(TensorId, Self)>, from: TensorId) -> Option<(TensorId, Self)> {
        match (self, before) {
            (_, None) => Some((from, self)),
            (Self::Folded, Some((whole, Self::Channel(number)))) => {
                Some((whole, Self::FoldedChannel(number)))
            }
            _ => None,
        }
    }
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

/// Finds the tensors of `plan` that need not be written, with source and transformation.
///
/// Readers must be able to transform them: convolutions that read them at their own resolution, predicted kernels
/// for pooled tensors, additions for unfolded ones, and folds for single channels. The source must be written, and
/// `is_way` must allow the transformation.
fn derived(plan: &Plan, is_way: impl Fn(Derived) -> bool) -> Vec<Option<(TensorId, Derived)>> {
    let mut derived: Vec<Option<(TensorId, Derived)>> = vec![None; plan.tensors().len()];
    for layer in plan.layers() {
        let follows = Derived::of(plan, layer).filter(|(_, how)| is_way(*how));
        derived[layer.output().index()] =
            follows.and_then(|(from, how)| how.after(derived[from.index()], from));
        for id in layer.inputs() {
            let is_read_in_place = match (layer, derived[id.index()]) {
                (Layer::Conv(conv), Some((_, how))) => {
                    !matches!(how, Derived::Unfolded | Derived::Channel(_))
                        && conv.inputs.iter().all(|read| read.tensor != id || *read == Read::same(id))
                }
                (Layer::Filter(filter), Some((_, Derived::Pooled))) => {
                    id != filter.features
                        && filter.images.iter().all(|(read, _)| read.tensor != id || *read == Read::same(id))
                }
                (Layer::Add { input, more, .. }, Some((_, Derived::Unfolded))) => id == *more && id != *input,
                (Layer::SpaceToDepth { output, .. }, Some((_, Derived::Channel(_)))) => {
                    derived[output.index()].is_some()
                }
                _ => false,
            };
            if !is_read_in_place {
                derived[id.index()] = None;
            }
        }
    }
    for id in plan.states().iter().map(|state| state.next).chain([plan.output()]) {
        derived[id.index()] = None;
    }
    // A channel that is not only folded has to be written, and folds of it then read it directly.
    for layer in plan.layers() {
        let Layer::SpaceToDepth { input, output } = layer else { continue };
        match derived[output.index()] {
            None => derived[input.index()] = None,
            Some((_, Derived::FoldedChannel(_))) if derived[input.index()].is_none() => {
                derived[output.index()] = Some((*input, Derived::Folded));
            }
            _ => {}
        }
    }
    derived
}

/// Tensor that joins the colours and the mask of the input of `plan`, if there is one.
fn known(plan: &Plan) -> Option<TensorId> {
    let inputs = plan.inputs();
    plan.layers().iter().find_map(|layer| match layer {
        Layer::Join { colour, weight, output }
            if *colour == inputs.colour && Some(*weight) == inputs.mask =>
        {
            Some(*output)
        }
        _ => None,
    })
}

/// Tensor that layers of `plan` can read as a list of samples, if any. `known` joins the colours and mask of the
/// input.
fn sampled(plan: &Plan, known: Option<TensorId>) -> Option<TensorId> {
    let inputs = plan.inputs();
    match (known, inputs.mask) {
        (Some(known), _) => takes_samples(plan, known).then_some(known),
        (None, None) => is_read_by_convolutions(plan, inputs.colour).then_some(inputs.colour),
        (None, Some(_)) => None,
    }
}

/// Whether only convolutions read `id`, at its own resolution.
fn is_read_by_convolutions(plan: &Plan, id: TensorId) -> bool {
    let is_read_alike = |layer: &Layer| match layer {
        Layer::Conv(conv) => conv.inputs.iter().all(|read| read.tensor != id || *read == Read::same(id)),
        _ => !layer.inputs().contains(&id),
    };
    let is_kept = plan.output() == id || plan.states().iter().any(|state| state.next == id);
    plan.layers().iter().all(is_read_alike) && !is_kept
}

/// Whether all readers of `known`, and of the colours and mask that it joins, accept a list of samples.
fn takes_samples(plan: &Plan, known: TensorId) -> bool {
    let is_sampled =
        |id: TensorId| id == known || id == plan.inputs().colour || Some(id) == plan.inputs().mask;
    plan.layers().iter().all(|layer| match layer {
        Layer::Join { colour, weight, .. } if is_input(plan, *colour, *weight) => true,
        Layer::Bypass { colour, mask, input, .. } if is_input(plan, *colour, *mask) => !is_sampled(*input),
        Layer::Spread { known: id, .. }
        | Layer::Blend { known: id, .. }
        | Layer::Doubt { known: id, .. }
        | Layer::Accumulate { known: id, .. }
            if *id == known =>
        {
            layer.inputs().into_iter().filter(|id| is_sampled(*id)).count() == 1
        }
        _ => !layer.inputs().into_iter().any(is_sampled),
    }) && !plan.states().iter().any(|state| is_sampled(state.next))
        && !is_sampled(plan.output())
}

/// Inputs of `layer`, with `known` in place of the colours and mask that it joins.
fn reads(plan: &Plan, layer: &Layer, known: Option<TensorId>) -> Vec<TensorId> {
    match (layer, known) {
        (Layer::Bypass { colour, mask, input, .. }, Some(known)) if is_input(plan, *colour, *mask) => {
            vec![known, *input]
        }
        _ => layer.inputs(),
    }
}

/// Whether these are the colours and the mask of the input of `plan`.
pub fn is_input(plan: &Plan, colour: TensorId, mask: TensorId) -> bool {
    (colour, Some(mask)) == (plan.inputs().colour, plan.inputs().mask)
}

/// For each layer of `plan`, the tensors that it reads for the last time. Tensors that are `derived` do not count.
fn finished(
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

/// States that are points: inputs of reprojection layers.
fn points(plan: &Plan) -> Vec<TensorId> {
    let moved = plan.layers().iter().filter_map(|layer| match layer {
        Layer::Reproject { input, .. } => Some(*input),
        _ => None,
    });
    moved.collect()
}

/// For each state of `plan`, whether its next value is finite for any input.
///
/// This holds for clamped pictures and for samples, which are clamped too. It also holds after convolutions with
/// ReLU, whose implementation turns infinite values and NaN into 0.
fn stays_finite(plan: &Plan) -> Vec<bool> {
    let is_finite = |layer: &Layer| match layer {
        Layer::Clamp { .. } | Layer::Accumulate { .. } => true,
        Layer::Conv(conv) => conv.activation == Activation::Relu,
        _ => false,
    };
    let made = |id: TensorId| plan.layers().iter().find(|layer| layer.output() == id);
    plan.states().iter().map(|state| made(state.next).is_some_and(is_finite)).collect()
}

/// Tensor that is written to the frame.
fn shown(plan: &Plan) -> TensorId {
    let cut = plan.layers().iter().find_map(|layer| match layer {
        Layer::Clamp { input, output } if *input == plan.output() => Some(*output),
        _ => None,
    });
    cut.filter(|cut| plan.states().iter().any(|state| state.next == *cut)).unwrap_or(plan.output())
}

/// Finds the addition to the picture of layer `number`, if that is a predicted kernel and the addend is predicted
/// from the same features.
fn addition(
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
    let Layer::Add { input, more, .. } = layers[added] else { return None };
    let is_of_pixels = if filter.expand == 1 { more == conv.output } else { unfolds(more) };
    let is_all = finished[added].contains(&filter.output) && finished[added].contains(&conv.output);
    (is_alike && is_of_pixels && input == filter.output && is_all).then_some(Addition { predicted, added })
}

/// Whether exactly one input of `layer` is `id`.
fn reads_once(layer: &Layer, id: TensorId) -> bool {
    layer.inputs().into_iter().filter(|read| *read == id).count() == 1
}

/// For each layer of `plan`, the number of consecutive pointwise layers from it on whose intermediate results
/// nothing else reads.
fn changes(plan: &Plan, finished: &[Vec<TensorId>]) -> Vec<usize> {
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
fn fades(plan: &Plan, finished: &[Vec<TensorId>]) -> Vec<bool> {
    let layers = plan.layers();
    let fades = |number: usize| match (&layers[number], layers.get(number + 1)) {
        (Layer::Reproject { output, .. }, Some(next @ Layer::Accumulate { .. })) => {
            next.begins_as() == Some(*output) && finished[number + 1].contains(output)
        }
        _ => false,
    };
    (0..layers.len()).map(fades).collect()
}

/// For each layer of `plan`, how it can be fused with the next one, if both are 3×3 convolutions.
fn pairs(plan: &Plan, finished: &[Vec<TensorId>], halved: &[bool]) -> Vec<Option<Pairing>> {
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
