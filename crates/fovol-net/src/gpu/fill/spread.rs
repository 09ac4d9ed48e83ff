use crate::gpu::kernel::shader::SPREAD;
use crate::gpu::kernel::{Context, Groups, Kernel, Operand};
use crate::gpu::tensor::Place;
use crate::plan::{Blend, Smooth};

/// Makes the kernel of a smoothing.
pub fn smooth(context: &Context<'_>, layer: &Smooth) -> Kernel {
    let output = Place::Tensor(layer.output);
    let operands = vec![Operand::Shape(output), context.read(layer.input), Operand::Write(output)];
    kernel("smooth_input", operands, output)
}

/// Makes the kernel that fills weighted pixels from a picture.
pub fn blend(context: &Context<'_>, layer: &Blend) -> Kernel {
    let output = Place::Tensor(layer.output);
    let operands = vec![
        Operand::Shape(output),
        context.read(layer.known),
        context.read(layer.base),
        Operand::Write(output),
    ];
    kernel("blend", operands, output)
}

fn kernel(entry_point: &'static str, operands: Vec<Operand>, output: Place) -> Kernel {
    Kernel { shader: SPREAD, entry_point, constants: Vec::new(), operands, groups: Groups::of(output) }
}
