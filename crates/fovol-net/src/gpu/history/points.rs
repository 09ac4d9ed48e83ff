use crate::gpu::kernel::shader::POINTS;
use crate::gpu::kernel::{Context, Groups, Kernel, Operand};
use crate::gpu::tensor::Place;
use crate::plan::{Reproject, Splat};

/// Makes the kernel that moves points along the motion.
pub fn reproject(context: &Context<'_>, layer: &Reproject) -> Kernel {
    let output = Place::Tensor(layer.output);
    let operands = vec![
        Operand::Shape(output),
        context.read(layer.input),
        context.read(layer.motion),
        Operand::Write(output),
    ];
    kernel("reproject", operands, output)
}

/// Makes the kernel that resamples points at pixel centres.
pub fn splat(context: &Context<'_>, layer: &Splat) -> Kernel {
    let output = Place::Tensor(layer.output);
    let operands = vec![Operand::Shape(output), context.read(layer.input), Operand::Write(output)];
    kernel("splat", operands, output)
}

fn kernel(entry_point: &'static str, operands: Vec<Operand>, output: Place) -> Kernel {
    Kernel { shader: POINTS, entry_point, constants: Vec::new(), operands, groups: Groups::of(output) }
}
