use super::kernel::{Groups, Kernel, Operand, flag};
use super::layer::Making;
use super::shader::WARP;
use super::tensor::Place;
use crate::plan::TensorId;

/// Makes the kernel of `Layer::Warp`, which moves `input` along `motion`.
pub fn kernel(making: &Making<'_>, input: TensorId, motion: TensorId, output: TensorId) -> Kernel {
    let level = making.plan.tensor(output).level;
    let place = Place::Tensor(output);
    Kernel {
        shader: WARP,
        entry_point: "warp",
        constants: vec![("HALVED", flag(making.is_halved(output))), ("LEVEL", f64::from(level))],
        operands: vec![Operand::Shape(place), making.read(input), making.read(motion), Operand::Write(place)],
        groups: Groups::of(place),
    }
}
