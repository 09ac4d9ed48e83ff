use crate::gpu::kernel::shader::ACCUMULATE;
use crate::gpu::kernel::{Context, Groups, Kernel, Operand, flag};
use crate::gpu::tensor::Place;
use crate::plan::Accumulate;

/// Makes the kernel that adds earlier samples to those of the frame.
pub fn kernel(context: &Context<'_>, layer: &Accumulate) -> Kernel {
    let &Accumulate { known, before, share, fade, output } = layer;
    let output = Place::Tensor(output);
    let level = share.map_or(0, |share| context.plan.tensor(share).level);
    Kernel {
        shader: ACCUMULATE,
        entry_point: "accumulate",
        constants: vec![
            ("FADE", f64::from(fade)),
            ("IS_SHARED", flag(share.is_some())),
            ("SHARE_LEVEL", f64::from(level)),
        ],
        operands: vec![
            Operand::Shape(output),
            context.read(known),
            context.read(before),
            context.read(share.unwrap_or(before)),
            Operand::Write(output),
        ],
        groups: Groups::of(output),
    }
}
