use crate::Result;
use crate::gpu::kernel::shader::NORM;
use crate::gpu::kernel::{Context, Groups, Kernel, Operand, activation_number, bits};
use crate::gpu::tensor::{MOMENT_GROUPS, Place, padded};
use crate::plan::Norm;

/// Makes the kernels of a normalisation.
///
/// # Errors
/// Weights that are missing.
pub fn kernels(context: &Context<'_>, norm: &Norm) -> Result<Vec<Kernel>> {
    let (weights, bias) = context.parameters(&norm.name)?;
    let output = Place::Tensor(norm.output);
    let constants = vec![
        ("ACTIVATION", activation_number(norm.activation)),
        ("HALVES", bits(&[context.is_halved(norm.input), context.is_halved(norm.output)])),
    ];
    let operands = vec![
        Operand::Shape(output),
        context.read(norm.input),
        Operand::Change(Place::Moments),
        context.learned(&norm.name, &padded(weights)),
        context.learned(&norm.name, &padded(bias)),
        Operand::Write(output),
    ];
    let kernel = |entry_point, groups| Kernel {
        shader: NORM,
        entry_point,
        constants: constants.clone(),
        operands: operands.clone(),
        groups,
    };
    Ok(vec![
        kernel("measure", Groups::Count(MOMENT_GROUPS)),
        kernel("merge", Groups::Count(1)),
        kernel("normalise", Groups::of(output)),
    ])
}
