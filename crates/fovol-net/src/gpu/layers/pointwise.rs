use crate::gpu::kernel::shader::POINTWISE;
use crate::gpu::kernel::{Context, Groups, Kernel, Operand};
use crate::gpu::tensor::Place;
use crate::plan::{Add, Bypass, Clamp, Scale, TensorId};

/// Makes the kernel of a product with a number, plus a number.
pub fn scale(context: &Context<'_>, layer: &Scale) -> Kernel {
    let constants = vec![("FACTOR", f64::from(layer.factor)), ("OFFSET", f64::from(layer.offset))];
    Kernel { constants, ..change(context, "scale", layer.input, &[], layer.output) }
}

/// Makes the kernel of a clamp to 0…1.
pub fn clamp(context: &Context<'_>, layer: &Clamp) -> Kernel {
    change(context, "clamp_input", layer.input, &[], layer.output)
}

/// Makes the kernel of a sum.
pub fn add(context: &Context<'_>, layer: &Add) -> Kernel {
    match context.moved(layer.more) {
        Some(folded) => change(context, "add_unfolded", layer.input, &[folded], layer.output),
        None => change(context, "add", layer.input, &[layer.more], layer.output),
    }
}

/// Makes the kernel of a choice by the sample mask.
pub fn bypass(context: &Context<'_>, layer: &Bypass) -> Kernel {
    let &Bypass { colour, mask, input, output } = layer;
    match context.is_known(colour, mask) {
        true => change(context, "bypass_known", input, &[colour], output),
        false => change(context, "bypass", input, &[colour, mask], output),
    }
}

fn change(
    context: &Context<'_>,
    entry_point: &'static str,
    input: TensorId,
    others: &[TensorId],
    output: TensorId,
) -> Kernel {
    let output = Place::Tensor(output);
    let mut operands = vec![Operand::Shape(output), context.read(input), Operand::Write(output)];
    operands.extend(others.iter().map(|id| context.read(*id)));
    Kernel { shader: POINTWISE, entry_point, constants: Vec::new(), operands, groups: Groups::of(output) }
}
