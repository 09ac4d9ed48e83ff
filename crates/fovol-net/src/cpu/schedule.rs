//! In which order a network does with the layers of its plan what, and how long it keeps tensors.

use crate::plan::{Activation, Layer, Plan, Read, TensorId};

/// What follows from the plan alone, found once for all frames.
#[derive(Debug)]
pub struct Schedule {
    /// For each layer the tensors that nothing reads after it.
    pub finished: Vec<Vec<TensorId>>,
    /// For each layer whether it and the next one can be made together, and how.
    pub pairs: Vec<Option<Pairing>>,
    /// For each layer how many from it on do no more than change the numbers of one picture.
    pub changes: Vec<usize>,
    /// For each tensor, if each of its numbers follows at once from few of another one's, that other, and how: it is never
    /// written.
    pub derived: Vec<Option<(TensorId, Derived)>>,
    /// What holds both colours and mask of the input, once they are joined.
    pub known: Option<TensorId>,
    /// What samples stand for wherever it is read, if they do: that, or the colours of the input alone. Neither it nor what
    /// is joined to it is ever written.
    pub sampled: Option<TensorId>,
    /// For each layer, if it is a predicted kernel to the picture of which the same features add something, the convolution
    /// that predicts that and the layer that adds it: all of them are made together.
    pub additions: Vec<Option<Addition>>,
    /// For each layer whether it moves points of which the next one leaves something at once.
    pub fades: Vec<bool>,
    /// States that are points.
    pub points: Vec<TensorId>,
    /// For each state whether what it becomes is finite whatever it was made of.
    pub stays_finite: Vec<bool>,
    /// What the frame is made of: the output, or what it is cut to, as frames are anyway.
    pub shown: TensorId,
    /// Whether that is needed as a tensor too.
    pub keeps_shown: bool,
}

/// What is added to a filtered picture.
#[derive(Debug, Clone, Copy)]
pub struct Addition {
    /// The layer that predicts it.
    pub predicted: usize,
    /// The layer that adds it.
    pub added: usize,
}

/// Two convolutions, the second of which alone reads what the first writes.
#[derive(Debug, Clone, Copy)]
pub struct Pairing {
    /// Which input of the first has the shape of what the second writes and is read by nothing after them.
    pub replaced: Option<usize>,
}

/// How a tensor follows from another one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Derived {
    /// 2×2 pixels are one with four times the channels.
    Folded,
    /// The other way round.
    Unfolded,
    /// 2×2 pixels are their mean.
    Pooled,
    /// It is a channel of this number.
    Channel(usize),
    /// 2×2 pixels of that channel are one with four channels.
    FoldedChannel(usize),
}

impl Derived {
    /// How the output of `layer` of `plan` follows from which tensor.
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

    /// The same of what follows in this way from what follows from a tensor as `before` says; none where that has to be written.
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
    /// Whether layer `number`, which is `layer`, may write over the tensor `id` that it reads.
    pub fn is_free(&self, number: usize, layer: &Layer, id: TensorId) -> bool {
        self.finished[number].contains(&id) && reads_once(layer, id)
    }

    /// That of `plan` if `halved` says of each tensor whether its numbers take two bytes, and `is_way` whether tensors may follow
    /// from others so.
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

    /// That of `plan` with every tensor written on its own.
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

/// For each tensor of `plan` that only convolutions read, as it is, or predicted kernels too where it is pooled, or that is unfolded
/// and only added to something, or a channel and only folded: from which one it follows in which way, if it does from one that
/// is written, and if that `is_way`.
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
    // A channel that is folded after all has to be there, and what was folded of one that is there follows from it.
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

/// What the colours and the mask of the input of `plan` are joined to, if they are.
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

/// What samples stand for in `plan`, if they do, given what the input's colours and mask are joined to.
fn sampled(plan: &Plan, known: Option<TensorId>) -> Option<TensorId> {
    let inputs = plan.inputs();
    match (known, inputs.mask) {
        (Some(known), _) => takes_samples(plan, known).then_some(known),
        (None, None) => is_read_by_convolutions(plan, inputs.colour).then_some(inputs.colour),
        (None, Some(_)) => None,
    }
}

/// Whether convolutions alone read `id`, as it is.
fn is_read_by_convolutions(plan: &Plan, id: TensorId) -> bool {
    let is_read_alike = |layer: &Layer| match layer {
        Layer::Conv(conv) => conv.inputs.iter().all(|read| read.tensor != id || *read == Read::same(id)),
        _ => !layer.inputs().contains(&id),
    };
    let is_kept = plan.output() == id || plan.states().iter().any(|state| state.next == id);
    plan.layers().iter().all(is_read_alike) && !is_kept
}

/// Whether samples will do wherever `known`, or what is joined to it, is read.
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

/// What `layer` reads where `known` is read instead of what is joined there.
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

/// For each layer of `plan` the tensors that are read there for the last time, if those that are `derived` are not there.
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

/// States that are points: those that are moved as such.
fn points(plan: &Plan) -> Vec<TensorId> {
    let moved = plan.layers().iter().filter_map(|layer| match layer {
        Layer::Reproject { input, .. } => Some(*input),
        _ => None,
    });
    moved.collect()
}

/// For each state of `plan` whether what it becomes is finite whatever it was made of: pictures that are cut, samples, which
/// were, and what convolutions make that leave nothing negative, as they do not leave what is not finite either.
fn stays_finite(plan: &Plan) -> Vec<bool> {
    let is_finite = |layer: &Layer| match layer {
        Layer::Clamp { .. } | Layer::Accumulate { .. } => true,
        Layer::Conv(conv) => conv.activation == Activation::Relu,
        _ => false,
    };
    let made = |id: TensorId| plan.layers().iter().find(|layer| layer.output() == id);
    plan.states().iter().map(|state| made(state.next).is_some_and(is_finite)).collect()
}

/// What the frame is made of.
fn shown(plan: &Plan) -> TensorId {
    let cut = plan.layers().iter().find_map(|layer| match layer {
        Layer::Clamp { input, output } if *input == plan.output() => Some(*output),
        _ => None,
    });
    cut.filter(|cut| plan.states().iter().any(|state| state.next == *cut)).unwrap_or(plan.output())
}

/// What is added to the picture of layer `number`, if that is a predicted kernel and something of the same features is.
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

/// Whether only one of the inputs of `layer` is `id`.
fn reads_once(layer: &Layer, id: TensorId) -> bool {
    layer.inputs().into_iter().filter(|read| *read == id).count() == 1
}

/// For each layer of `plan` how many from it on change a picture that nothing else reads on the way.
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

/// For each layer of `plan` whether it moves points that the next one alone reads, to leave something of them.
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

/// For each layer of `plan` whether it and the next one can be made together.
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
