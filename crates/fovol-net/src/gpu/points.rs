use super::kernel::{Groups, Kernel, Operand};
use super::layer::Making;
use super::shader::POINTS;
use super::tensor::Place;
use crate::plan::TensorId;

/// The kernel that takes the points of `input` where `motion` does.
pub fn reproject(making: &Making<'_>, input: TensorId, motion: TensorId, output: TensorId) -> Kernel {
    let output = Place::Tensor(output);
    let operands =
        vec![Operand::Shape(output), making.read(input), making.read(motion), Operand::Write(output)];
    kernel("reproject", operands, output)
}

/// The kernel of what the points of `input` tell of the centres of pixels.
pub fn splat(making: &Making<'_>, input: TensorId, output: TensorId) -> Kernel {
    let output = Place::Tensor(output);
    let operands = vec![Operand::Shape(output), making.read(input), Operand::Write(output)];
    kernel("splat", operands, output)
}

fn kernel(entry_point: &'static str, operands: Vec<Operand>, output: Place) -> Kernel {
    Kernel { shader: POINTS, entry_point, constants: Vec::new(), operands, groups: Groups::of(output) }
}
