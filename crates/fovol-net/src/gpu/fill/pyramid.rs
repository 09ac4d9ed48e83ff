use crate::gpu::kernel::shader::{PYRAMID, PYRAMID_TOP};
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

/// Levels that one kernel pulls and pushes back.
const TOP: u32 = 3;

/// Makes the kernels that spread weighted pixels over the frame.
pub fn spread(context: &Context<'_>, layer: &Spread) -> Vec<Kernel> {
    let &Spread { known, base, levels, output } = layer;
    let pulled = base.map_or(Pulled::Known, Pulled::Differences);
    kernels(context, (known, pulled), [levels, 1], output)
}

/// Makes the kernels of the confidence in earlier frames.
pub fn history_confidence(context: &Context<'_>, layer: &HistoryConfidence) -> Vec<Kernel> {
    let &HistoryConfidence { known, prior, fresh, levels, output } = layer;
    let lowest = context.plan.tensor(output).level;
    kernels(context, (known, Pulled::Squares([prior, fresh])), [levels, lowest], output)
}

/// Makes the kernels of a pyramid of `levels`, whose level `lowest` makes `output`.
fn kernels(
    context: &Context<'_>,
    (known, pulled): (TensorId, Pulled),
    [levels, lowest]: [u32; 2],
    output: TensorId,
) -> Vec<Kernel> {
    // The coarsest levels turn together if there is a level below them, and none of them but the finest is wanted.
    let turned = (levels + 1).saturating_sub(TOP);
    let turns = turned > 1 && lowest <= turned;
    let pulls = if turns { turned - 1 } else { levels.max(lowest) };
    let pushed = if turns { turned } else { levels };
    let mut kernels = vec![first_pull(context, known, pulled)];
    kernels.extend((2..=pulls).map(|level| {
        let finer = Operand::Read(Place::Level(level - 1));
        pull(0.0, [finer.clone(), finer.clone(), finer], level)
    }));
    kernels.extend(turns.then(|| turn(turned)));
    kernels.extend((lowest + 1..pushed).rev().map(push));
    kernels.push(made(context, pulled, (lowest, lowest < pushed), output));
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

/// Makes the kernel that fills `level` from the one below it, by way of the two above.
fn turn(level: u32) -> Kernel {
    let to = Place::Level(level);
    Kernel {
        shader: PYRAMID_TOP,
        entry_point: "turn",
        constants: Vec::new(),
        operands: vec![Operand::Shape(to), Operand::Read(Place::Level(level - 1)), Operand::Write(to)],
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

/// Makes the kernel that computes the output from level `lowest`; if it `is_pushed`, it is filled from the next one first.
fn made(context: &Context<'_>, pulled: Pulled, (lowest, is_pushed): (u32, bool), output: TensorId) -> Kernel {
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
