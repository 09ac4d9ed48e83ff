use crate::gpu::kernel::shader::ACCUMULATE;
use crate::gpu::kernel::{Context, Groups, Kernel, Operand, flag};
use crate::gpu::tensor::{BLOCK, Place};
use crate::plan::{Accumulate, POINT, Reproject};

/// Makes the kernel that adds earlier samples to those of the frame.
pub fn kernel(context: &Context<'_>, layer: &Accumulate) -> Kernel {
    let output = Place::Tensor(layer.output);
    made(context, layer, ("accumulate", context.read(layer.before)), Groups::of(output))
}

/// Makes the kernel that moves points as `moved` says and adds them to the samples of the frame.
pub fn moved(context: &Context<'_>, moved: &Reproject, layer: &Accumulate) -> Kernel {
    let output = Place::Tensor(layer.output);
    // A thread writes both blocks of a point.
    let groups = Groups::Over(output, [8, 8, POINT.div_ceil(BLOCK) as u32]);
    let mut kernel = made(context, layer, ("accumulate_moved", context.read(moved.input)), groups);
    kernel.operands.push(context.read(moved.motion));
    kernel
}

fn made(
    context: &Context<'_>,
    layer: &Accumulate,
    (entry_point, before): (&'static str, Operand),
    groups: Groups,
) -> Kernel {
    let &Accumulate { known, share, fade, output, .. } = layer;
    let output = Place::Tensor(output);
    let level = share.map_or(0, |share| context.plan.tensor(share).level);
    let share_or_before = share.map_or(before.clone(), |share| context.read(share));
    Kernel {
        shader: ACCUMULATE,
        entry_point,
        constants: vec![
            ("FADE", f64::from(fade)),
            ("IS_SHARED", flag(share.is_some())),
            ("SHARE_LEVEL", f64::from(level)),
        ],
        operands: vec![
            Operand::Shape(output),
            context.read(known),
            before,
            share_or_before,
            Operand::Write(output),
        ],
        groups,
    }
}
