use super::kernel::{Groups, Kernel, Operand};
use super::layer::Making;
use super::shader::POINTWISE;
use super::tensor::Place;
use crate::plan::{Layer, TensorId};

/// Makes the kernel of a pointwise layer; `None` for other layers.
pub fn kernel(making: &Making<'_>, layer: &Layer) -> Option<Kernel> {
    let output = layer.output();
    Some(match layer {
        Layer::Scale { input, factor, offset, .. } => {
            let constants = vec![("FACTOR", f64::from(*factor)), ("OFFSET", f64::from(*offset))];
            Kernel { constants, ..change(making, "scale", *input, &[], output) }
        }
        Layer::Clamp { input, .. } => change(making, "clamp_input", *input, &[], output),
        Layer::Add { input, more, .. } => match making.moved(*more) {
            Some(folded) => change(making, "add_unfolded", *input, &[folded], output),
            None => change(making, "add", *input, &[*more], output),
        },
        Layer::Bypass { colour, mask, input, .. } => match making.is_known(*colour, *mask) {
            true => change(making, "bypass_known", *input, &[*colour], output),
            false => change(making, "bypass", *input, &[*colour, *mask], output),
        },
        _ => return None,
    })
}

fn change(
    making: &Making<'_>,
    entry_point: &'static str,
    input: TensorId,
    others: &[TensorId],
    output: TensorId,
) -> Kernel {
    let output = Place::Tensor(output);
    let mut operands = vec![Operand::Shape(output), making.read(input), Operand::Write(output)];
    operands.extend(others.iter().map(|id| making.read(*id)));
    Kernel { shader: POINTWISE, entry_point, constants: Vec::new(), operands, groups: Groups::of(output) }
}
