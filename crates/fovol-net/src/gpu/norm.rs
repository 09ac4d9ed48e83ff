use super::conv::{activation_number, padded};
use super::kernel::{Groups, Kernel, Operand, bits};
use super::layer::Making;
use super::shader::NORM;
use super::tensor::Place;
use crate::Result;
use crate::plan::Norm;

/// Number of workgroups that read a tensor, as in shaders/norm.wgsl.
pub const GROUPS: u32 = 64;

/// Makes the kernels of a normalisation.
///
/// # Errors
/// Weights that are missing.
pub fn kernels(making: &Making<'_>, norm: &Norm) -> Result<Vec<Kernel>> {
    let (weights, bias) = making.parameters(&norm.name)?;
    let output = Place::Tensor(norm.output);
    let constants = vec![
        ("ACTIVATION", activation_number(norm.activation)),
        ("HALVES", bits(&[making.is_halved(norm.input), making.is_halved(norm.output)])),
    ];
    let operands = vec![
        Operand::Shape(output),
        making.read(norm.input),
        Operand::Change(Place::Moments),
        making.learned(&norm.name, &padded(weights)),
        making.learned(&norm.name, &padded(bias)),
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
        kernel("measure", Groups::Count(GROUPS)),
        kernel("merge", Groups::Count(1)),
        kernel("normalise", Groups::of(output)),
    ])
}
