use crate::gpu::kernel::shader::SPREAD;
use crate::gpu::kernel::{Context, Groups, Kernel, Operand};
use crate::gpu::tensor::Place;
use crate::plan::TensorId;

/// Makes the kernel of `Layer::Smooth`.
pub fn smooth(context: &Context<'_>, input: TensorId, output: TensorId) -> Kernel {
    let output = Place::Tensor(output);
    let operands = vec![Operand::Shape(output), context.read(input), Operand::Write(output)];
    kernel("smooth_input", operands, output)
}

/// Makes the kernel of `Layer::Blend`: `known`, filled from `base`.
pub fn blend(context: &Context<'_>, known: TensorId, base: TensorId, output: TensorId) -> Kernel {
    let output = Place::Tensor(output);
    let operands =
        vec![Operand::Shape(output), context.read(known), context.read(base), Operand::Write(output)];
    kernel("blend", operands, output)
}

fn kernel(entry_point: &'static str, operands: Vec<Operand>, output: Place) -> Kernel {
    Kernel { shader: SPREAD, entry_point, constants: Vec::new(), operands, groups: Groups::of(output) }
}
