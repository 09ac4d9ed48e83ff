//! Makes kernels of convolutions: with cooperative matrices if the device has them and they fit, else with plain
//! threads.

mod method;
mod weights;

use crate::Result;
use crate::gpu::kernel::{
    Context, Groups, Kernel, Operand, activation_number, bits, flag, resize_number, too_many,
};
use crate::gpu::tensor::{BLOCK, Place, padded};
use crate::plan::{Conv, Padding, TensorId};
use bytemuck::{Pod, Zeroable};
use half::f16;
use method::{COLUMNS, Units};
use weights::Packing;
use wgpu::BufferUsages;

/// Largest number of input tensors of a convolution.
const SOURCES: usize = 4;
/// End of each input tensor, in blocks of all inputs together. Twin of `Sources` in shaders/convolution.wgsl.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct Sources {
    ends: [u32; SOURCES],
}

/// Number in shaders for reading 2×2 pixels as four channels.
const FOLDED: u32 = 3;

/// Makes the kernel of a convolution.
///
/// # Errors
/// Weights that are missing, and more than four input tensors.
pub fn kernel(context: &Context<'_>, conv: &Conv) -> Result<Kernel> {
    if conv.inputs.is_empty() || conv.inputs.len() > SOURCES {
        return Err(too_many(&conv.name, conv.inputs.len(), SOURCES));
    }
    let (weights, bias) = context.parameters(&conv.name)?;
    let channels: Vec<usize> = conv.inputs.iter().map(|read| context.channels(read.tensor)).collect();
    let units = Units { matrices: context.matrices, limits: context.gpu.device().limits() };
    let method = units.method(conv, channels.iter().sum(), bias.len());
    let packing = Packing::new(method.edge, conv.size, &channels, bias.len());
    let packed = packing.packed(weights);
    let learned = match method.edge {
        BLOCK => context.learned(&conv.name, &packed),
        _ => context.learned(&conv.name, &packed.into_iter().map(f16::from_f32).collect::<Vec<_>>()),
    };
    let output = Place::Tensor(conv.output);
    let mut operands = vec![Operand::Shape(output), sources(context, &channels)];
    operands.extend((0..SOURCES).map(|i| context.read(stored(context, conv, i))));
    operands.extend([learned, context.learned(&conv.name, &padded(bias)), Operand::Write(output)]);
    let mut constants = common_constants(context, conv);
    constants.push(("TILES", packing.tiles as f64));
    constants.extend(method.constants.iter().map(|(name, value)| (*name, f64::from(*value))));
    let blocks = (packing.tiles * method.edge / BLOCK) as u32;
    Ok(Kernel {
        shader: method.shader,
        entry_point: "convolve",
        constants,
        operands,
        groups: Groups::Over(output, [COLUMNS, method.rows, blocks]),
    })
}

/// Stored tensor of input `i` of a convolution. Absent inputs are bound too, as input 0.
fn stored(context: &Context<'_>, conv: &Conv, i: usize) -> TensorId {
    let read = conv.inputs.get(i).unwrap_or(&conv.inputs[0]);
    context.moved(read.tensor).unwrap_or(read.tensor)
}

/// Constants of `conv` for both methods.
fn common_constants(context: &Context<'_>, conv: &Conv) -> Vec<(&'static str, f64)> {
    let mut halves: Vec<bool> = (0..SOURCES).map(|i| context.is_halved(stored(context, conv, i))).collect();
    halves.push(context.is_halved(conv.output));
    let reads = conv.inputs.iter().rev().fold(0, |all, read| match context.moved(read.tensor) {
        Some(_) => 4 * all + FOLDED,
        None => 4 * all + resize_number(read.resize),
    });
    vec![
        ("SIZE", conv.size as f64),
        ("STRIDE", conv.stride as f64),
        ("REPLICATE", flag(conv.padding == Padding::Replicate)),
        ("ACTIVATION", activation_number(conv.activation)),
        ("HALVES", bits(&halves)),
        ("READS", f64::from(reads)),
    ]
}

/// Uniform buffer with the ends of inputs of these `channels`.
fn sources(context: &Context<'_>, channels: &[usize]) -> Operand {
    let all: usize = channels.iter().map(|count| count.div_ceil(BLOCK)).sum();
    let mut ends = [all as u32; SOURCES];
    let mut end = 0;
    for (to, count) in ends.iter_mut().zip(channels) {
        end += count.div_ceil(BLOCK) as u32;
        *to = end;
    }
    let bytes = bytemuck::bytes_of(&Sources { ends }).to_vec();
    Operand::Uniform(context.buffer("sources", &bytes, BufferUsages::UNIFORM))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::kernel::shader::{CONV, CONV_MATRICES_8, CONV_MATRICES_16};
    use fovol_gpu::assert_twins;

    #[test]
    fn shaders_read_the_same_struct() {
        for shader in [CONV, CONV_MATRICES_8, CONV_MATRICES_16] {
            assert_twins!(shader, "Sources", Sources { ends });
        }
    }
}
