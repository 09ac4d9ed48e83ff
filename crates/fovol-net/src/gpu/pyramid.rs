use super::kernel::{Groups, Kernel, Operand, flag};
use super::layer::Making;
use super::shader::PYRAMID;
use super::tensor::Place;
use crate::plan::{DOUBT_ALLOWED, DOUBT_EPSILON, DOUBT_SHARE, TensorId};

/// What is pulled; the numbers are those of shaders/pyramid.wgsl.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Pulled {
    /// Known pixels.
    Known,
    /// What they differ by from a picture of half their resolution.
    Differences(TensorId),
    /// The mean squares by which they differ from a picture and from one of half its resolution.
    Squares([TensorId; 2]),
}

/// The kernels that spread `known` over the frame, as a correction of `base` where there is one.
pub fn spread(
    making: &Making<'_>,
    known: TensorId,
    base: Option<TensorId>,
    levels: u32,
    output: TensorId,
) -> Vec<Kernel> {
    let pulled = base.map_or(Pulled::Known, Pulled::Differences);
    let mut kernels = completed(making, known, pulled, [levels, 1]);
    kernels.push(made(making, pulled, [levels, 1], output));
    kernels
}

/// The kernels that find how far the first picture of `expected` is believed where samples are `known` and give the second.
pub fn doubt(
    making: &Making<'_>,
    known: TensorId,
    expected: [TensorId; 2],
    levels: u32,
    output: TensorId,
) -> Vec<Kernel> {
    let pulled = Pulled::Squares(expected);
    let lowest = making.plan.tensor(output).level;
    let mut kernels = completed(making, known, pulled, [levels, lowest]);
    kernels.push(made(making, pulled, [levels, lowest], output));
    kernels
}

/// The kernels up to, but without, what is missing at level `lowest`.
fn completed(
    making: &Making<'_>,
    known: TensorId,
    pulled: Pulled,
    [levels, lowest]: [u32; 2],
) -> Vec<Kernel> {
    let mut kernels = vec![first_pull(making, known, pulled)];
    kernels.extend((2..=levels.max(lowest)).map(|level| {
        let finer = Operand::Read(Place::Level(level - 1));
        pull(0.0, [finer.clone(), finer.clone(), finer], level)
    }));
    kernels.extend((lowest + 1..levels).rev().map(push));
    kernels
}

fn first_pull(making: &Making<'_>, known: TensorId, pulled: Pulled) -> Kernel {
    let known = making.read(known);
    match pulled {
        Pulled::Known => pull(0.0, [known.clone(), known.clone(), known], 1),
        Pulled::Differences(base) => pull(1.0, [known, making.read(base), making.read(base)], 1),
        Pulled::Squares([prior, fresh]) => pull(2.0, [known, making.read(prior), making.read(fresh)], 1),
    }
}

/// From twice the resolution of `level` to it.
fn pull(pulled: f64, [known, prior, fresh]: [Operand; 3], level: u32) -> Kernel {
    let to = Place::Level(level);
    Kernel {
        shader: PYRAMID,
        entry_point: "pull",
        constants: vec![("PULLED", pulled)],
        operands: vec![Operand::Shape(to), known, prior, fresh, Operand::Write(to)],
        groups: Groups::of(to),
    }
}

/// Adds what is missing at `level` from the next one.
fn push(level: u32) -> Kernel {
    let to = Place::Level(level);
    Kernel {
        shader: PYRAMID,
        entry_point: "push",
        constants: Vec::new(),
        operands: vec![Operand::Shape(to), Operand::Read(Place::Level(level + 1)), Operand::Change(to)],
        groups: Groups::of(to),
    }
}

/// What level `lowest` gives in the end.
fn made(making: &Making<'_>, pulled: Pulled, [levels, lowest]: [u32; 2], output: TensorId) -> Kernel {
    let is_pushed = lowest < levels;
    let level = Operand::Read(Place::Level(lowest));
    let coarser = if is_pushed { Operand::Read(Place::Level(lowest + 1)) } else { level.clone() };
    let (number, base) = match pulled {
        Pulled::Known => (0.0, level.clone()),
        Pulled::Differences(base) => (1.0, making.read(base)),
        Pulled::Squares(_) => (2.0, level.clone()),
    };
    let to = Place::Tensor(output);
    Kernel {
        shader: PYRAMID,
        entry_point: "make",
        constants: vec![
            ("MADE", number),
            ("IS_PUSHED", flag(is_pushed)),
            ("DOUBT_EPSILON", f64::from(DOUBT_EPSILON)),
            ("DOUBT_ALLOWED", f64::from(DOUBT_ALLOWED)),
            ("DOUBT_SHARE", f64::from(DOUBT_SHARE)),
        ],
        operands: vec![Operand::Shape(to), coarser, level, base, Operand::Write(to)],
        groups: Groups::of(to),
    }
}
