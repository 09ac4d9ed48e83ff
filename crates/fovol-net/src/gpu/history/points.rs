use crate::gpu::kernel::shader::POINTS;
use crate::gpu::kernel::{Context, Groups, Kernel, Operand};
use crate::gpu::tensor::Place;
use crate::plan::TensorId;

/// Makes the kernel of `Layer::Reproject`, which moves the points of `input` along `motion`.
pub fn reproject(context: &Context<'_>, input: TensorId, motion: TensorId, output: TensorId) -> Kernel {
    let output = Place::Tensor(output);
    let operands =
        vec![Operand::Shape(output), context.read(input), context.read(motion), Operand::Write(output)];
    kernel("reproject", operands, output)
}

/// Makes the kernel of `Layer::Splat`, which resamples the points of `input` at pixel centres.
pub fn splat(context: &Context<'_>, input: TensorId, output: TensorId) -> Kernel {
    let output = Place::Tensor(output);
    let operands = vec![Operand::Shape(output), context.read(input), Operand::Write(output)];
    kernel("splat", operands, output)
}

fn kernel(entry_point: &'static str, operands: Vec<Operand>, output: Place) -> Kernel {
    Kernel { shader: POINTS, entry_point, constants: Vec::new(), operands, groups: Groups::of(output) }
}
