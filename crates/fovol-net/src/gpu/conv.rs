//! Makes kernels of convolutions: with cooperative matrices if the device has them and they fit, else with plain
//! threads.

use super::conv_weights::Packing;
use super::kernel::{Groups, Kernel, Operand, bits, flag};
use super::layer::{Making, too_many};
use super::shader::{CONV, CONV_MATRICES_8, CONV_MATRICES_16};
use super::tensor::{BLOCK, Place};
use crate::Result;
use crate::plan::{Activation, Conv, Padding, Resize, TensorId};
use bytemuck::{Pod, Zeroable};
use fovol_gpu::{Matrices, Shader};
use half::f16;
use wgpu::BufferUsages;

/// Largest number of input tensors of a convolution.
const SOURCES: usize = 4;
/// Columns of pixels of a workgroup, as in shaders/convolution.wgsl.
const COLUMNS: u32 = 16;
/// Padding after the channels of a pixel in workgroup memory, as in shaders/conv_matrices.wgsl.
const PADDING: u32 = 8;

/// End of each input tensor, in blocks of all inputs together. Twin of `Sources` in shaders/convolution.wgsl.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct Sources {
    ends: [u32; SOURCES],
}

/// Number of `activation` in shaders.
pub fn activation_number(activation: Activation) -> f64 {
    match activation {
        Activation::None => 0.0,
        Activation::Relu => 1.0,
        Activation::Elu => 2.0,
    }
}

/// Number of `resize` in shaders.
pub fn resize_number(resize: Resize) -> u32 {
    match resize {
        Resize::Same => 0,
        Resize::Bilinear => 1,
        Resize::Nearest => 2,
    }
}

/// Number in shaders for reading 2×2 pixels as four channels.
const FOLDED: u32 = 3;

/// Method by which a workgroup computes its part of a convolution.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Means {
    shader: Shader,
    /// Channels that are multiplied together: those of a block for threads, or the edge of a matrix.
    edge: usize,
    /// Rows of pixels of a workgroup.
    rows: u32,
    /// Further constants of the shader.
    constants: Vec<(&'static str, u32)>,
}

impl Means {
    /// Method with plain threads, for any device.
    fn threads(conv: &Conv) -> Self {
        let fours = if conv.stride == 1 { 4 } else { 2 };
        Self { shader: CONV, edge: BLOCK, rows: 4 * fours, constants: vec![("ROWS", fours)] }
    }

    /// Method with `matrices`, with as many rows as the threads and workgroup memory in `limits` allow. `None` if
    /// not even two rows fit.
    fn matrices(matrices: Matrices, conv: &Conv, limits: &wgpu::Limits) -> Option<Self> {
        let (edge, (least, most)) = (matrices.edge(), matrices.subgroup());
        let shader = if edge == 8 { CONV_MATRICES_8 } else { CONV_MATRICES_16 };
        let (size, stride) = (conv.size as u32, conv.stride as u32);
        let with = |rows: u32| {
            let threads = COLUMNS / edge * rows / 2 * most;
            let subgroups = threads.div_ceil(least);
            let patch = ((COLUMNS - 1) * stride + size) * ((rows - 1) * stride + size);
            let bytes = 2 * patch * (edge + PADDING) + 4 * subgroups * edge * edge;
            let fits = threads <= limits.max_compute_invocations_per_workgroup
                && threads <= limits.max_compute_workgroup_size_x
                && bytes <= limits.max_compute_workgroup_storage_size;
            let constants = vec![("ROWS", rows), ("THREADS", threads), ("SUBGROUPS", subgroups)];
            fits.then_some(Self { shader, edge: edge as usize, rows, constants })
        };
        [8, 4, 2].into_iter().find_map(with)
    }
}

/// Capabilities of a device.
#[derive(Debug, Clone)]
struct Units {
    matrices: Option<Matrices>,
    limits: wgpu::Limits,
}

impl Units {
    /// Chooses the method for `conv` from `inputs` to `outputs` channels: matrices, unless padding would more than
    /// double the products.
    fn means(&self, conv: &Conv, inputs: usize, outputs: usize) -> Means {
        let padded = |edge: usize| inputs.next_multiple_of(edge) * outputs.next_multiple_of(edge);
        let is_worth = |matrices: &Matrices| padded(matrices.edge() as usize) <= 2 * inputs * outputs;
        let matrices = self.matrices.filter(is_worth);
        let means = matrices.and_then(|matrices| Means::matrices(matrices, conv, &self.limits));
        means.unwrap_or_else(|| Means::threads(conv))
    }
}

/// Makes the kernel of a convolution.
///
/// # Errors
/// Weights that are missing, and more than four input tensors.
pub fn kernel(making: &Making<'_>, conv: &Conv) -> Result<Kernel> {
    if conv.inputs.is_empty() || conv.inputs.len() > SOURCES {
        return Err(too_many(&conv.name, conv.inputs.len(), SOURCES));
    }
    let (weights, bias) = making.parameters(&conv.name)?;
    let channels: Vec<usize> = conv.inputs.iter().map(|read| making.channels(read.tensor)).collect();
    let units = Units { matrices: making.matrices, limits: making.gpu.device().limits() };
    let means = units.means(conv, channels.iter().sum(), bias.len());
    let packing = Packing::new(means.edge, conv.size, &channels, bias.len());
    let packed = packing.packed(weights);
    let learned = match means.edge {
        BLOCK => making.learned(&conv.name, &packed),
        _ => making.learned(&conv.name, &packed.into_iter().map(f16::from_f32).collect::<Vec<_>>()),
    };
    let output = Place::Tensor(conv.output);
    let mut operands = vec![Operand::Shape(output), sources(making, &channels)];
    operands.extend((0..SOURCES).map(|i| making.read(stored(making, conv, i))));
    operands.extend([learned, making.learned(&conv.name, &padded(bias)), Operand::Write(output)]);
    let mut constants = common_constants(making, conv);
    constants.push(("TILES", packing.tiles as f64));
    constants.extend(means.constants.iter().map(|(name, value)| (*name, f64::from(*value))));
    let blocks = (packing.tiles * means.edge / BLOCK) as u32;
    Ok(Kernel {
        shader: means.shader,
        entry_point: "convolve",
        constants,
        operands,
        groups: Groups::Over(output, [COLUMNS, means.rows, blocks]),
    })
}

/// Stored tensor of input `i` of a convolution. Absent inputs are bound too, as input 0.
fn stored(making: &Making<'_>, conv: &Conv, i: usize) -> TensorId {
    let read = conv.inputs.get(i).unwrap_or(&conv.inputs[0]);
    making.moved(read.tensor).unwrap_or(read.tensor)
}

/// Constants of `conv` for both methods.
fn common_constants(making: &Making<'_>, conv: &Conv) -> Vec<(&'static str, f64)> {
    let mut halves: Vec<bool> = (0..SOURCES).map(|i| making.is_halved(stored(making, conv, i))).collect();
    halves.push(making.is_halved(conv.output));
    let reads = conv.inputs.iter().rev().fold(0, |all, read| match making.moved(read.tensor) {
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
fn sources(making: &Making<'_>, channels: &[usize]) -> Operand {
    let all: usize = channels.iter().map(|count| count.div_ceil(BLOCK)).sum();
    let mut ends = [all as u32; SOURCES];
    let mut end = 0;
    for (to, count) in ends.iter_mut().zip(channels) {
        end += count.div_ceil(BLOCK) as u32;
        *to = end;
    }
    let bytes = bytemuck::bytes_of(&Sources { ends }).to_vec();
    Operand::Uniform(making.buffer("sources", &bytes, BufferUsages::UNIFORM))
}

/// Pads `values` with zeros to whole blocks.
pub fn padded(values: &[f32]) -> Vec<f32> {
    let mut padded = values.to_vec();
    padded.resize(values.len().next_multiple_of(BLOCK), 0.0);
    padded
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::{Layer, Named};
    use fovol_gpu::assert_twins;

    #[test]
    fn shaders_read_the_same_struct() {
        for shader in [CONV, CONV_MATRICES_8, CONV_MATRICES_16] {
            assert_twins!(shader, "Sources", Sources { ends });
        }
    }

    fn units(edge: u32, subgroup: (u32, u32)) -> Units {
        Units { matrices: Some(Matrices::new(edge, subgroup)), limits: wgpu::Limits::default() }
    }

    /// Share of all products of a network that use matrices.
    fn share(named: Named, units: &Units) -> f64 {
        let plan = named.config().plan().unwrap();
        let channels = |id: TensorId| plan.tensor(id).channels;
        let mut made = [0.0; 2];
        for layer in plan.layers() {
            let Layer::Conv(conv) = layer else { continue };
            let inputs = conv.inputs.iter().map(|read| channels(read.tensor)).sum();
            let products = inputs * channels(conv.output) * conv.size * conv.size;
            let at = plan.tensor(conv.output).level;
            let by_threads = units.means(conv, inputs, channels(conv.output)).shader == CONV;
            made[usize::from(by_threads)] += (products as f64) / f64::from(1 << (2 * at));
        }
        made[0] / (made[0] + made[1])
    }

    #[test]
    fn most_products_of_every_network_are_made_by_matrices() {
        for units in [units(8, (8, 8)), units(8, (32, 32)), units(16, (32, 32)), units(16, (32, 64))] {
            for named in Named::ALL {
                assert!(share(named, &units) >= 0.85, "{named} {units:?}: {}", share(named, &units));
            }
        }
        let none = Units { matrices: None, limits: wgpu::Limits::default() };
        assert_eq!(share(Named::WNetFast, &none), 0.0);
    }

    #[test]
    fn workgroups_keep_within_what_a_device_has() {
        let plan = Named::DeepFoveaOrig.config().plan().unwrap();
        let conv = plan.layers().iter().find_map(|layer| match layer {
            Layer::Conv(conv) if conv.stride == 2 => Some(conv),
            _ => None,
        });
        let limits = wgpu::Limits::default();
        let rows =
            |subgroup| Means::matrices(Matrices::new(16, subgroup), conv.unwrap(), &limits).map(|m| m.rows);
        assert_eq!([(32, 32), (8, 32), (64, 64), (8, 128)].map(rows), [Some(4), Some(2), Some(4), None]);
    }
}
