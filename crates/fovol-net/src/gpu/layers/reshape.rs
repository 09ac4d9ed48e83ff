use crate::gpu::kernel::shader::{POOL, RESHAPE};
use crate::gpu::kernel::{Context, Groups, Kernel, Operand, flag};
use crate::gpu::tensor::Place;
use crate::plan::{Layer, TensorId};

/// Makes the kernel of a layer that reorders or averages elements; `None` for other layers.
pub fn kernel(context: &Context<'_>, layer: &Layer) -> Option<Kernel> {
    let output = layer.output();
    Some(match layer {
        Layer::Pool { input, .. } => pool(context, *input, output),
        Layer::SpaceToDepth { input, .. } => moved(context, "space_to_depth", &[*input], output),
        Layer::DepthToSpace { input, .. } => moved(context, "depth_to_space", &[*input], output),
        Layer::Join { colour, weight, .. } => moved(context, "join", &[*colour, *weight], output),
        Layer::Part { input, first, .. } => {
            let constants = vec![("FIRST", *first as f64)];
            Kernel { constants, ..moved(context, "part", &[*input], output) }
        }
        _ => return None,
    })
}

fn moved(context: &Context<'_>, entry_point: &'static str, inputs: &[TensorId], output: TensorId) -> Kernel {
    let output = Place::Tensor(output);
    let mut operands = vec![Operand::Shape(output), context.read(inputs[0]), Operand::Write(output)];
    operands.extend(inputs[1..].iter().map(|id| context.read(*id)));
    Kernel { shader: RESHAPE, entry_point, constants: Vec::new(), operands, groups: Groups::of(output) }
}

fn pool(context: &Context<'_>, input: TensorId, output: TensorId) -> Kernel {
    let place = Place::Tensor(output);
    Kernel {
        shader: POOL,
        entry_point: "pool",
        constants: vec![("HALVED", flag(context.is_halved(output)))],
        operands: vec![Operand::Shape(place), context.read(input), Operand::Write(place)],
        groups: Groups::of(place),
    }
}
