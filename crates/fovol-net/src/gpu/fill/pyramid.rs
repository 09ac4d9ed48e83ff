use crate::gpu::kernel::shader::PYRAMID;
use crate::gpu::kernel::{Context, Groups, Kernel, Operand, flag};
use crate::gpu::tensor::Place;
use crate::plan::{DOUBT_ALLOWED, DOUBT_EPSILON, DOUBT_SHARE, TensorId};

/// Input of the pyramid. Discriminants are those of shaders/pyramid.wgsl.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Pulled {
    /// Weighted pixels.
    Known,
    /// Residuals of a picture of half the resolution.
    Differences(TensorId),
    /// Mean squared residuals of a picture and of one of half the resolution.
    Squares([TensorId; 2]),
}

/// Makes the kernels of `Layer::Spread`: `known` spread over the frame, or with `base` its residuals, which are
/// added to it.
pub fn spread(
    context: &Context<'_>,
    known: TensorId,
    base: Option<TensorId>,
    levels: u32,
    output: TensorId,
) -> Vec<Kernel> {
    let pulled = base.map_or(Pulled::Known, Pulled::Differences);
    let mut kernels = completed(context, known, pulled, [levels, 1]);
    kernels.push(made(context, pulled, [levels, 1], output));
    kernels
}

/// Makes the kernels of `Layer::Doubt`. `expected` has the reprojected last output and the fill of this frame.
pub fn doubt(
    context: &Context<'_>,
    known: TensorId,
    expected: [TensorId; 2],
    levels: u32,
    output: TensorId,
) -> Vec<Kernel> {
    let pulled = Pulled::Squares(expected);
    let lowest = context.plan.tensor(output).level;
    let mut kernels = completed(context, known, pulled, [levels, lowest]);
    kernels.push(made(context, pulled, [levels, lowest], output));
    kernels
}

/// Makes the kernels of all pulls, and of all pushes but the one to level `lowest`.
fn completed(
    context: &Context<'_>,
    known: TensorId,
    pulled: Pulled,
    [levels, lowest]: [u32; 2],
) -> Vec<Kernel> {
    let mut kernels = vec![first_pull(context, known, pulled)];
    kernels.extend((2..=levels.max(lowest)).map(|level| {
        let finer = Operand::Read(Place::Level(level - 1));
        pull(0.0, [finer.clone(), finer.clone(), finer], level)
    }));
    kernels.extend((lowest + 1..levels).rev().map(push));
    kernels
}

fn first_pull(context: &Context<'_>, known: TensorId, pulled: Pulled) -> Kernel {
    let known = context.read(known);
    match pulled {
        Pulled::Known => pull(0.0, [known.clone(), known.clone(), known], 1),
        Pulled::Differences(base) => pull(1.0, [known, context.read(base), context.read(base)], 1),
        Pulled::Squares([prior, fresh]) => pull(2.0, [known, context.read(prior), context.read(fresh)], 1),
    }
}

/// Makes the kernel that pulls to `level` from twice its resolution.
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

/// Makes the kernel that pushes to `level` from the next one.
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

/// Makes the kernel that pushes to level `lowest` and computes the output from it.
fn made(context: &Context<'_>, pulled: Pulled, [levels, lowest]: [u32; 2], output: TensorId) -> Kernel {
    let is_pushed = lowest < levels;
    let level = Operand::Read(Place::Level(lowest));
    let coarser = if is_pushed { Operand::Read(Place::Level(lowest + 1)) } else { level.clone() };
    let (number, base) = match pulled {
        Pulled::Known => (0.0, level.clone()),
        Pulled::Differences(base) => (1.0, context.read(base)),
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
