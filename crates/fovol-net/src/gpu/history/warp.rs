use crate::gpu::kernel::shader::WARP;
use crate::gpu::kernel::{Context, Groups, Kernel, Operand, flag};
use crate::gpu::tensor::Place;
use crate::plan::TensorId;

/// Makes the kernel of `Layer::Warp`, which moves `input` along `motion`.
pub fn kernel(context: &Context<'_>, input: TensorId, motion: TensorId, output: TensorId) -> Kernel {
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
