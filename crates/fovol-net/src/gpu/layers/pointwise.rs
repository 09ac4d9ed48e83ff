use crate::gpu::kernel::shader::POINTWISE;
use crate::gpu::kernel::{Context, Groups, Kernel, Operand, flag};
use crate::gpu::tensor::Place;
use crate::plan::{Bypass, Layer, Scale, TensorId};

/// Makes the kernel of a product with a number, plus a number.
pub fn scale(context: &Context<'_>, layer: &Scale) -> Kernel {
    let output = Place::Tensor(layer.output);
    Kernel {
        shader: POINTWISE,
        entry_point: "scale",
        constants: vec![("FACTOR", f64::from(layer.factor)), ("OFFSET", f64::from(layer.offset))],
        operands: vec![Operand::Shape(output), context.read(layer.input), Operand::Write(output)],
        groups: Groups::of(output),
    }
}

/// Layers that one kernel computes: an addition, a bypass and a clamp in this order, each at most once.
#[derive(Debug, Default)]
struct Changes {
    /// Second summand.
    more: Option<TensorId>,
    bypass: Option<Bypass>,
    clamps: bool,
}

impl Changes {
    /// Takes in `layer`, which follows the layers so far. Returns whether it can.
    fn take(&mut self, layer: &Layer) -> bool {
        let is_new = match layer {
            Layer::Add(_) => self.more.is_none() && self.bypass.is_none(),
            Layer::Bypass(_) => self.bypass.is_none(),
            Layer::Clamp(_) => true,
            _ => false,
        } && !self.clamps;
        match layer {
            _ if !is_new => {}
            Layer::Add(add) => self.more = Some(add.more),
            Layer::Bypass(bypass) => self.bypass = Some(*bypass),
            _ => self.clamps = true,
        }
        is_new
    }
}

/// Makes the kernel of the additions, bypasses and clamps from layer `number` on that one kernel can compute, and returns their
/// number. If the last one makes the picture of the frame, the kernel shows it too. `None` if the layer is of another kind.
pub fn changes(context: &Context<'_>, number: usize) -> Option<(Kernel, usize)> {
    let layers = context.plan.layers();
    let mut changes = Changes::default();
    let all = &layers[number..number + context.schedule.changes[number]];
    let count = all.iter().take_while(|layer| changes.take(layer)).count();
    let (first, last) = all[..count].first().zip(all[..count].last())?;
    let kernel = kernel(context, &changes, [first.changed()?, last.output()]);
    Some((kernel, count))
}

fn kernel(context: &Context<'_>, changes: &Changes, [input, output]: [TensorId; 2]) -> Kernel {
    let (added, more) = match changes.more.map(|more| (more, context.moved(more))) {
        None => (0.0, input),
        Some((more, None)) => (1.0, more),
        Some((_, Some(folded))) => (2.0, folded),
    };
    let (bypassed, colour, mask) = match changes.bypass {
        None => (0.0, input, input),
        Some(Bypass { colour, mask, .. }) if context.is_known(colour, mask) => (2.0, colour, colour),
        Some(Bypass { colour, mask, .. }) => (1.0, colour, mask),
    };
    let to = Place::Tensor(output);
    let mut operands = vec![Operand::Shape(to), context.read(input), Operand::Write(to)];
    operands.extend([more, colour, mask].map(|id| context.read(id)));
    let is_shown = output == context.schedule.shown;
    if is_shown {
        operands.extend([Operand::Shape(Place::Frame), Operand::Write(Place::Frame)]);
    }
    let constants = vec![("ADDED", added), ("BYPASSED", bypassed), ("CLAMPED", flag(changes.clamps))];
    let entry_point = if is_shown { "change_and_show" } else { "change" };
    Kernel { shader: POINTWISE, entry_point, constants, operands, groups: Groups::of(to) }
}
