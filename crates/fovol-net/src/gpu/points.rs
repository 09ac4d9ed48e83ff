use super::kernel::{Groups, Kernel, Operand};
use super::layer::Making;
use super::shader::POINTS;
use super::tensor::Place;
use crate::plan::TensorId;

/// Makes the kernel of `Layer::Reproject`, which moves the points of `input` along `motion`.
pub fn reproject(making: &Making<'_>, input: TensorId, motion: TensorId, output: TensorId) -> Kernel {
    let output = Place::Tensor(output);
    let operands =
        vec![Operand::Shape(output), making.read(input), making.read(motion), Operand::Write(output)];
    kernel("reproject", operands, output)
}

/// Makes the kernel of `Layer::Splat`, which resamples the points of `input` at pixel centres.
pub fn splat(making: &Making<'_>, input: TensorId, output: TensorId) -> Kernel {
    let output = Place::Tensor(output);
    let operands = vec![Operand::Shape(output), making.read(input), Operand::Write(output)];
    kernel("splat", operands, output)
}

fn kernel(entry_point: &'static str, operands: Vec<Operand>, output: Place) -> Kernel {
    Kernel { shader: POINTS, entry_point, constants: Vec::new(), operands, groups: Groups::of(output) }
}
