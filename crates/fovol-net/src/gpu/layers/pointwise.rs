use crate::gpu::kernel::shader::POINTWISE;
use crate::gpu::kernel::{Context, Groups, Kernel, Operand};
use crate::gpu::tensor::Place;
use crate::plan::{Layer, TensorId};

/// Makes the kernel of a pointwise layer; `None` for other layers.
pub fn kernel(context: &Context<'_>, layer: &Layer) -> Option<Kernel> {
    let output = layer.output();
    Some(match layer {
        Layer::Scale { input, factor, offset, .. } => {
            let constants = vec![("FACTOR", f64::from(*factor)), ("OFFSET", f64::from(*offset))];
            Kernel { constants, ..change(context, "scale", *input, &[], output) }
        }
        Layer::Clamp { input, .. } => change(context, "clamp_input", *input, &[], output),
        Layer::Add { input, more, .. } => match context.moved(*more) {
            Some(folded) => change(context, "add_unfolded", *input, &[folded], output),
            None => change(context, "add", *input, &[*more], output),
        },
        Layer::Bypass { colour, mask, input, .. } => match context.is_known(*colour, *mask) {
            true => change(context, "bypass_known", *input, &[*colour], output),
            false => change(context, "bypass", *input, &[*colour, *mask], output),
        },
        _ => return None,
    })
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
