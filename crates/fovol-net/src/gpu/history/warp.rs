use crate::gpu::kernel::shader::WARP;
use crate::gpu::kernel::{Context, Groups, Kernel, Operand, flag};
use crate::gpu::tensor::Place;
use crate::plan::Warp;

/// Makes the kernel that moves a picture along the motion.
pub fn kernel(context: &Context<'_>, layer: &Warp) -> Kernel {
    let &Warp { input, motion, output } = layer;
    let level = context.plan.tensor(output).level;
    let place = Place::Tensor(output);
    Kernel {
        shader: WARP,
        entry_point: "warp",
        constants: vec![("HALVED", flag(context.is_halved(output))), ("LEVEL", f64::from(level))],
        operands: vec![
            Operand::Shape(place),
            context.read(input),
            context.read(motion),
            Operand::Write(place),
        ],
        groups: Groups::of(place),
    }
}
