use super::kernel::{Groups, Kernel, Operand};
use super::layer::Making;
use super::shader::SPREAD;
use super::tensor::Place;
use crate::plan::TensorId;

/// Makes the kernel of `Layer::Smooth`.
pub fn smooth(making: &Making<'_>, input: TensorId, output: TensorId) -> Kernel {
    let output = Place::Tensor(output);
    let operands = vec![Operand::Shape(output), making.read(input), Operand::Write(output)];
    kernel("smooth_input", operands, output)
}

/// Makes the kernel of `Layer::Blend`: `known`, filled from `base`.
pub fn blend(making: &Making<'_>, known: TensorId, base: TensorId, output: TensorId) -> Kernel {
    let output = Place::Tensor(output);
    let operands =
        vec![Operand::Shape(output), making.read(known), making.read(base), Operand::Write(output)];
    kernel("blend", operands, output)
}

fn kernel(entry_point: &'static str, operands: Vec<Operand>, output: Place) -> Kernel {
    Kernel { shader: SPREAD, entry_point, constants: Vec::new(), operands, groups: Groups::of(output) }
}
