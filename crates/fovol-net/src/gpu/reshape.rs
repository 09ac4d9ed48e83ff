use super::kernel::{Groups, Kernel, Operand, flag};
use super::layer::Making;
use super::shader::{POOL, RESHAPE};
use super::tensor::Place;
use crate::plan::{Layer, TensorId};

/// Makes the kernel of a layer that reorders or averages elements; `None` for other layers.
pub fn kernel(making: &Making<'_>, layer: &Layer) -> Option<Kernel> {
    let output = layer.output();
    Some(match layer {
        Layer::Pool { input, .. } => pool(making, *input, output),
        Layer::SpaceToDepth { input, .. } => moved(making, "space_to_depth", &[*input], output),
        Layer::DepthToSpace { input, .. } => moved(making, "depth_to_space", &[*input], output),
        Layer::Join { colour, weight, .. } => moved(making, "join", &[*colour, *weight], output),
        Layer::Part { input, first, .. } => {
            let constants = vec![("FIRST", *first as f64)];
            Kernel { constants, ..moved(making, "part", &[*input], output) }
        }
        _ => return None,
    })
}

fn moved(making: &Making<'_>, entry_point: &'static str, inputs: &[TensorId], output: TensorId) -> Kernel {
    let output = Place::Tensor(output);
    let mut operands = vec![Operand::Shape(output), making.read(inputs[0]), Operand::Write(output)];
    operands.extend(inputs[1..].iter().map(|id| making.read(*id)));
    Kernel { shader: RESHAPE, entry_point, constants: Vec::new(), operands, groups: Groups::of(output) }
}

fn pool(making: &Making<'_>, input: TensorId, output: TensorId) -> Kernel {
    let place = Place::Tensor(output);
    Kernel {
        shader: POOL,
        entry_point: "pool",
        constants: vec![("HALVED", flag(making.is_halved(output)))],
        operands: vec![Operand::Shape(place), making.read(input), Operand::Write(place)],
        groups: Groups::of(place),
    }
}
