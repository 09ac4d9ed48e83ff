//! In which order a network does with the layers of its plan what, and how long it keeps tensors.

use crate::plan::{Layer, Plan, Read, Resize, TensorId};

/// What follows from the plan alone, found once for all frames.
#[derive(Debug)]
pub struct Schedule {
    /// For each layer the tensors that nothing reads after it.
    pub finished: Vec<Vec<TensorId>>,
    /// For each layer whether it and the next one can be made together, and how.
    pub pairs: Vec<Option<Pairing>>,
    /// For each tensor, if it is nothing but another one with 2×2 pixels as one, that other: it is never written.
    pub folded: Vec<Option<TensorId>>,
}

/// Two convolutions, the second of which alone reads what the first writes.
#[derive(Debug, Clone, Copy)]
pub struct Pairing {
    /// Which input of the first has the shape of what the second writes and is read by nothing after them.
    pub replaced: Option<usize>,
}

impl Schedule {
    /// That of `plan` if `halved` says of each tensor whether its numbers take two bytes.
    pub fn new(plan: &Plan, halved: &[bool]) -> Self {
        let folded = folded(plan);
        let finished = finished(plan, &folded);
        Self { pairs: pairs(plan, &finished, halved), finished, folded }
    }

    /// That of `plan` with every tensor written on its own.
    pub fn layer_by_layer(plan: &Plan) -> Self {
        let folded = vec![None; plan.tensors().len()];
        Self { finished: finished(plan, &folded), pairs: vec![None; plan.layers().len()], folded }
    }
}

/// For each tensor of `plan` that only convolutions read and that is another one with 2×2 pixels as one, that other.
fn folded(plan: &Plan) -> Vec<Option<TensorId>> {
    let mut folded = vec![None; plan.tensors().len()];
    for layer in plan.layers() {
        match layer {
            Layer::SpaceToDepth { input, output } => folded[output.index()] = Some(*input),
            Layer::Conv(conv) => {
                let resized = conv.inputs.iter().filter(|read| read.resize != Resize::Same);
                resized.for_each(|read| folded[read.tensor.index()] = None);
            }
            other => other.inputs().iter().for_each(|id| folded[id.index()] = None),
        }
    }
    for id in plan.states().iter().map(|state| state.next).chain([plan.output()]) {
        folded[id.index()] = None;
    }
    folded
}

/// For each layer of `plan` the tensors that are read there for the last time, if those that are `folded` are not there.
fn finished(plan: &Plan, folded: &[Option<TensorId>]) -> Vec<Vec<TensorId>> {
    let mut last = vec![None; plan.tensors().len()];
    for (number, layer) in plan.layers().iter().enumerate() {
        if folded[layer.output().index()].is_none() {
            let read = layer.inputs().into_iter().map(|id| folded[id.index()].unwrap_or(id));
            read.for_each(|id| last[id.index()] = Some(number));
        }
    }
    for id in plan.states().iter().map(|state| state.next).chain([plan.output()]) {
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
            let count = first.inputs.iter().filter(|other| other.tensor == read.tensor).count();
            let is_free = finished[number].contains(&read.tensor) && count == 1;
            *read == Read::same(read.tensor) && is_alike && is_free
        });
        Some(Pairing { replaced })
    };
    (0..layers.len()).map(pair).collect()
}
