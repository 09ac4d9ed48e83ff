use crate::gpu::kernel::shader::{POOL, RESHAPE};
use crate::gpu::kernel::{Context, Groups, Kernel, Operand, flag};
use crate::gpu::tensor::Place;
use crate::plan::{DepthToSpace, Join, Part, Pool, SpaceToDepth, TensorId};

/// Makes the kernel of a fold of pixels into channels.
pub fn space_to_depth(context: &Context<'_>, layer: &SpaceToDepth) -> Kernel {
    moved(context, "space_to_depth", &[layer.input], layer.output)
}

/// Makes the kernel of an unfolding of channels into pixels.
pub fn depth_to_space(context: &Context<'_>, layer: &DepthToSpace) -> Kernel {
    moved(context, "depth_to_space", &[layer.input], layer.output)
}

/// Makes the kernel that joins colours and weights.
pub fn join(context: &Context<'_>, layer: &Join) -> Kernel {
    moved(context, "join", &[layer.colour, layer.weight], layer.output)
}

/// Makes the kernel that copies some of the channels.
pub fn part(context: &Context<'_>, layer: &Part) -> Kernel {
    let constants = vec![("FIRST", layer.first as f64)];
    Kernel { constants, ..moved(context, "part", &[layer.input], layer.output) }
}

fn moved(context: &Context<'_>, entry_point: &'static str, inputs: &[TensorId], output: TensorId) -> Kernel {
    let output = Place::Tensor(output);
    let mut operands = vec![Operand::Shape(output), context.read(inputs[0]), Operand::Write(output)];
    operands.extend(inputs[1..].iter().map(|id| context.read(*id)));
    Kernel { shader: RESHAPE, entry_point, constants: Vec::new(), operands, groups: Groups::of(output) }
}

/// Makes the kernel of an average of 2×2 pixels.
pub fn pool(context: &Context<'_>, layer: &Pool) -> Kernel {
    let place = Place::Tensor(layer.output);
    Kernel {
        shader: POOL,
        entry_point: "pool",
        constants: vec![("HALVED", flag(context.is_halved(layer.output)))],
        operands: vec![Operand::Shape(place), context.read(layer.input), Operand::Write(place)],
        groups: Groups::of(place),
    }
}
