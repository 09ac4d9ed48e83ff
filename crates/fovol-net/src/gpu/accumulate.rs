use super::kernel::{Groups, Kernel, Operand, flag};
use super::layer::Making;
use super::shader::ACCUMULATE;
use super::tensor::Place;
use crate::plan::TensorId;

/// Makes the kernel of `Layer::Accumulate`: `known`, and the earlier samples `before`, weighted by `share` and
/// `fade`.
pub fn kernel(
    making: &Making<'_>,
    known: TensorId,
    (before, share): (TensorId, Option<TensorId>),
    fade: f32,
    output: TensorId,
) -> Kernel {
    let output = Place::Tensor(output);
    let level = share.map_or(0, |share| making.plan.tensor(share).level);
    Kernel {
        shader: ACCUMULATE,
        entry_point: "accumulate",
        constants: vec![
            ("FADE", f64::from(fade)),
            ("IS_SHARED", flag(share.is_some())),
            ("SHARE_LEVEL", f64::from(level)),
        ],
        operands: vec![
            Operand::Shape(output),
            making.read(known),
            making.read(before),
            making.read(share.unwrap_or(before)),
            Operand::Write(output),
        ],
        groups: Groups::of(output),
    }
}
