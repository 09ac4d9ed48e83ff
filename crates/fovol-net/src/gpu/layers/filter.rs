use crate::Result;
use crate::gpu::kernel::shader::FILTER;
use crate::gpu::kernel::{Context, Groups, Kernel, Operand, bits, flag, resize_number, too_many};
use crate::gpu::tensor::{BLOCK, Place, padded};
use crate::plan::{Filter, Normalisation, Taps};

/// Largest number of images that a kernel weighs.
const IMAGES: usize = 4;

/// Largest number of blocks of four weights that a thread holds, limited by workgroup memory.
const MOST_HELD: usize = 12;

/// Makes the kernel of a predicted kernel.
///
/// # Errors
/// Weights that are missing, and more than four images.
pub fn kernel(context: &Context<'_>, filter: &Filter) -> Result<Kernel> {
    if filter.images.is_empty() || filter.images.len() > IMAGES {
        return Err(too_many(&filter.name, filter.images.len(), IMAGES));
    }
    let (weights, bias) = context.parameters(&filter.name)?;
    let (features, output) = (Place::Tensor(filter.features), Place::Tensor(filter.output));
    let mut operands = vec![
        Operand::Shape(output),
        Operand::Shape(features),
        context.read(filter.features),
        context.learned(&filter.name, &packed(weights, bias.len())),
        context.learned(&filter.name, &padded(bias)),
    ];
    let image = |i: usize| filter.images.get(i).unwrap_or(&filter.images[0]).0.tensor;
    operands.extend((0..IMAGES).map(|i| context.read(image(i))));
    operands.push(Operand::Write(output));
    let end = |last: usize| filter.images.iter().take(last + 1).map(|(_, taps)| taps.count()).sum::<usize>();
    let around: Vec<bool> = filter.images.iter().map(|(_, taps)| *taps == Taps::Around).collect();
    let reads = filter.images.iter().rev().fold(0, |all, (read, _)| 4 * all + resize_number(read.resize));
    // One thread for each feature and for each block of the images.
    let tile = 8 * filter.expand as u32;
    Ok(Kernel {
        shader: FILTER,
        entry_point: "weigh",
        constants: vec![
            ("EXPAND", filter.expand as f64),
            ("FEATURE_BLOCKS", (weights.len() / bias.len()).div_ceil(BLOCK) as f64),
            ("TAPS", filter.taps() as f64),
            ("SOFTMAX", flag(filter.normalisation == Normalisation::Softmax)),
            ("HALVED", flag(context.is_halved(filter.features))),
            ("HELD", bias.len().div_ceil(BLOCK).next_multiple_of(4).min(MOST_HELD) as f64),
            ("END_0", end(0) as f64),
            ("END_1", end(1) as f64),
            ("END_2", end(2) as f64),
            ("AROUND", bits(&around)),
            ("READS", f64::from(reads)),
        ],
        operands,
        groups: Groups::Over(output, [tile, tile, 1]),
    })
}

/// Packs `weights`, \[output\]\[input\], as \[block of outputs\]\[input\]\[output\], padded with zeros.
fn packed(weights: &[f32], outputs: usize) -> Vec<f32> {
    let inputs = weights.len() / outputs;
    let mut packed = Vec::new();
    for block in (0..outputs).step_by(BLOCK) {
        for input in 0..inputs.next_multiple_of(BLOCK) {
            packed.extend((block..block + BLOCK).map(|output| match output < outputs && input < inputs {
                true => weights[output * inputs + input],
                false => 0.0,
            }));
        }
    }
    packed
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::SQUARED_EPSILON;

    #[test]
    fn weights_lie_in_the_order_of_their_use() {
        // Two outputs of three inputs.
        let packed = packed(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0], 2);
        let expected = [[1.0, 4.0, 0.0, 0.0], [2.0, 5.0, 0.0, 0.0], [3.0, 6.0, 0.0, 0.0], [0.0; 4]].concat();
        assert_eq!(packed, expected);
    }

    #[test]
    fn the_epsilon_is_that_of_the_plan() {
        assert!(FILTER.source().contains(&format!("const EPSILON = {SQUARED_EPSILON:e};")));
    }
}
