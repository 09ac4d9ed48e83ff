use super::kernel::{Groups, Kernel, Operand, bits, flag};
use super::layer::{Making, too_many};
use super::shader::CONV;
use super::tensor::{BLOCK, Place};
use crate::Result;
use crate::plan::{Activation, Conv, Padding, Read, Resize};
use bytemuck::{Pod, Zeroable};
use wgpu::BufferUsages;

/// The most tensors that a convolution reads.
const SOURCES: usize = 4;
/// Columns of pixels of a workgroup; as in shaders/conv.wgsl.
const COLUMNS: u32 = 16;

/// Where the sources of a convolution end, in blocks of all together. Twin of `Sources` in shaders/conv.wgsl.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct Sources {
    ends: [u32; SOURCES],
}

/// `activation` as shaders know it.
pub fn activation_number(activation: Activation) -> f64 {
    match activation {
        Activation::None => 0.0,
        Activation::Relu => 1.0,
        Activation::Elu => 2.0,
    }
}

/// `resize` as shaders know it.
pub fn resize_number(resize: Resize) -> u32 {
    match resize {
        Resize::Same => 0,
        Resize::Bilinear => 1,
        Resize::Nearest => 2,
    }
}

/// 2×2 pixels as four channels, as shaders know it.
const FOLDED: u32 = 3;

/// The kernel of a convolution.
///
/// # Errors
/// Weights that are missing; more than four inputs.
pub fn kernel(making: &Making<'_>, conv: &Conv) -> Result<Kernel> {
    if conv.inputs.is_empty() || conv.inputs.len() > SOURCES {
        return Err(too_many(&conv.name, conv.inputs.len(), SOURCES));
    }
    let (weights, bias) = making.parameters(&conv.name)?;
    let channels: Vec<usize> = conv.inputs.iter().map(|read| making.channels(read.tensor)).collect();
    let packing = Packing::new(conv.size, &channels, bias.len());
    let output = Place::Tensor(conv.output);
    let rows = if conv.stride == 1 { 4 } else { 2 };
    let read = |read: &Read| making.moved(read.tensor).unwrap_or(read.tensor);
    let source = |i: usize| conv.inputs.get(i).unwrap_or(&conv.inputs[0]);
    let mut halves: Vec<bool> = (0..SOURCES).map(|i| making.is_halved(read(source(i)))).collect();
    halves.push(making.is_halved(conv.output));
    let mut operands = vec![Operand::Shape(output), packing.sources(making, &channels)];
    operands.extend((0..SOURCES).map(|i| making.read(read(source(i)))));
    operands.extend([
        making.learned(&conv.name, &packing.packed(weights)),
        making.learned(&conv.name, &padded(bias)),
        Operand::Write(output),
    ]);
    let reads = conv.inputs.iter().rev().fold(0, |all, read| match making.moved(read.tensor) {
        Some(_) => 4 * all + FOLDED,
        None => 4 * all + resize_number(read.resize),
    });
    Ok(Kernel {
        shader: CONV,
        entry_point: "convolve",
        constants: vec![
            ("SIZE", conv.size as f64),
            ("STRIDE", conv.stride as f64),
            ("REPLICATE", flag(conv.padding == Padding::Replicate)),
            ("ACTIVATION", activation_number(conv.activation)),
            ("BLOCKS", packing.blocks as f64),
            ("ROWS", f64::from(rows)),
            ("HALVES", bits(&halves)),
            ("READS", f64::from(reads)),
        ],
        operands,
        groups: Groups::Over(output, [COLUMNS, 4 * rows, packing.blocks as u32]),
    })
}

/// `values` with zeros to the end of the last block.
pub fn padded(values: &[f32]) -> Vec<f32> {
    let mut padded = values.to_vec();
    padded.resize(values.len().next_multiple_of(BLOCK), 0.0);
    padded
}

/// In which order shaders read the weights of a convolution.
struct Packing {
    size: usize,
    /// For each lane of each block that is read the channel of the inputs, if it is one.
    inputs: Vec<Option<usize>>,
    outputs: usize,
    /// Blocks of outputs that a workgroup makes.
    blocks: usize,
}

impl Packing {
    /// That of a convolution of inputs of so many `channels` each.
    fn new(size: usize, channels: &[usize], outputs: usize) -> Self {
        let mut inputs = Vec::new();
        let mut first = 0;
        for &count in channels {
            let lanes = 0..count.next_multiple_of(BLOCK);
            inputs.extend(lanes.map(|lane| (lane < count).then_some(first + lane)));
            first += count;
        }
        Self { size, inputs, outputs, blocks: blocks(outputs.div_ceil(BLOCK)) }
    }

    /// Where each input ends.
    fn sources(&self, making: &Making<'_>, channels: &[usize]) -> Operand {
        let mut ends = [(self.inputs.len() / BLOCK) as u32; SOURCES];
        let mut end = 0;
        for (to, count) in ends.iter_mut().zip(channels) {
            end += count.div_ceil(BLOCK) as u32;
            *to = end;
        }
        let bytes = bytemuck::bytes_of(&Sources { ends }).to_vec();
        Operand::Uniform(making.buffer("sources", &bytes, BufferUsages::UNIFORM))
    }

    /// `weights`, \[output\]\[input\]\[row\]\[column\], as \[workgroup\]\[block of inputs\]\[tap\]\[block of
    /// outputs\]\[input\]\[output\], zeros where there is none.
    fn packed(&self, weights: &[f32]) -> Vec<f32> {
        let taps = self.size * self.size;
        let count = self.inputs.iter().flatten().count();
        let mut packed = Vec::new();
        for workgroup in 0..self.outputs.div_ceil(BLOCK * self.blocks) {
            for block in self.inputs.chunks(BLOCK) {
                let matrices = (0..taps).flat_map(|tap| (0..self.blocks).map(move |of| (tap, of)));
                for ((tap, of), input) in matrices.flat_map(|at| block.iter().map(move |input| (at, input))) {
                    let first = (workgroup * self.blocks + of) * BLOCK;
                    packed.extend((first..first + BLOCK).map(|output| match input {
                        Some(input) if output < self.outputs => {
                            weights[(output * count + input) * taps + tap]
                        }
                        _ => 0.0,
                    }));
                }
            }
        }
        packed
    }
}

/// How many of `all` blocks of channels a workgroup makes: as many as share what is read, and as few as leave none of them
/// without work.
fn blocks(all: usize) -> usize {
    let cost = |blocks: &usize| all.div_ceil(*blocks) * (2 * blocks + 1);
    (1..=4).rev().min_by_key(cost).unwrap_or(1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovol_gpu::assert_twins;

    #[test]
    fn shaders_read_the_same_struct() {
        assert_twins!(CONV, "Sources", Sources { ends });
    }

    #[test]
    fn workgroups_share_work_without_waste() {
        assert_eq!([1, 2, 3, 4, 6, 8, 12, 20, 32].map(blocks), [1, 2, 3, 4, 3, 4, 4, 4, 4]);
    }

    #[test]
    fn weights_lie_in_the_order_of_their_use() {
        // Three and one inputs, of which each begins a block; nine outputs.
        let packing = Packing::new(1, &[3, 1], 9);
        let weights: Vec<f32> = (0..9 * 4).map(|i| i as f32 + 1.0).collect();
        let packed = packing.packed(&weights);
        // Three blocks of outputs by two of inputs.
        assert_eq!((packing.blocks, packed.len()), (3, 6 * BLOCK * BLOCK));
        // Output 1, input 2: the second lane of the third row of the first block.
        assert_eq!(packed[2 * BLOCK + 1], weights[4 + 2]);
        // The fourth row has no input.
        assert_eq!(packed[3 * BLOCK..4 * BLOCK], [0.0; 4]);
        let sum: f32 = packed.iter().sum();
        assert_eq!(sum, weights.iter().sum::<f32>());
    }
}
