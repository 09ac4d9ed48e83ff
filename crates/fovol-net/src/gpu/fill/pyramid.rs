use crate::gpu::kernel::shader::PYRAMID;
use crate::gpu::kernel::{Context, Groups, Kernel, Operand, flag};
use crate::gpu::tensor::Place;
use crate::plan::{
    CONFIDENCE_ALLOWED, CONFIDENCE_EPSILON, CONFIDENCE_SHARE, HistoryConfidence, Spread, TensorId,
};

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

/// Makes the kernels that spread weighted pixels over the frame.
pub fn spread(context: &Context<'_>, layer: &Spread) -> Vec<Kernel> {
    let &Spread { known, base, levels, output } = layer;
    let pulled = base.map_or(Pulled::Known, Pulled::Differences);
    let mut kernels = completed(context, known, pulled, [levels, 1]);
    kernels.push(made(context, pulled, [levels, 1], output));
    kernels
}

/// Makes the kernels of the confidence in earlier frames.
pub fn history_confidence(context: &Context<'_>, layer: &HistoryConfidence) -> Vec<Kernel> {
    let &HistoryConfidence { known, prior, fresh, levels, output } = layer;
    let pulled = Pulled::Squares([prior, fresh]);
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
            ("CONFIDENCE_EPSILON", f64::from(CONFIDENCE_EPSILON)),
            ("CONFIDENCE_ALLOWED", f64::from(CONFIDENCE_ALLOWED)),
            ("CONFIDENCE_SHARE", f64::from(CONFIDENCE_SHARE)),
        ],
        operands: vec![Operand::Shape(to), coarser, level, base, Operand::Write(to)],
        groups: Groups::of(to),
    }
}
