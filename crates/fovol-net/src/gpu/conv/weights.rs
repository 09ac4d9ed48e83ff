//! Packs the weights of convolutions in the order in which shaders read them.

use crate::gpu::tensor::BLOCK;

/// Order in which shaders read the weights of a convolution.
pub struct Packing {
    size: usize,
    /// For each lane of each input block, the input channel; `None` for padding.
    inputs: Vec<Option<usize>>,
    outputs: usize,
    /// Channels of a tile, for inputs and outputs.
    edge: usize,
    /// Number of output tiles of a workgroup.
    pub tiles: usize,
}

impl Packing {
    /// Order for a convolution of input tensors of these `channels`, in tiles of `edge` channels.
    pub fn new(edge: usize, size: usize, channels: &[usize], outputs: usize) -> Self {
        let mut inputs = Vec::new();
        let mut first = 0;
        for &count in channels {
            let lanes = 0..count.next_multiple_of(BLOCK);
            inputs.extend(lanes.map(|lane| (lane < count).then_some(first + lane)));
            first += count;
        }
        inputs.resize(inputs.len().next_multiple_of(edge), None);
        Self { size, inputs, outputs, edge, tiles: tiles(outputs.div_ceil(edge)) }
    }

    /// Packs `weights`, \[output\]\[input\]\[row\]\[column\], as \[workgroup\]\[tile of inputs\]\[tap\]\[tile of
    /// outputs\]\[input\]\[output\], padded with zeros.
    pub fn packed(&self, weights: &[f32]) -> Vec<f32> {
        let taps = self.size * self.size;
        let count = self.inputs.iter().flatten().count();
        let mut packed = Vec::new();
        for workgroup in 0..self.outputs.div_ceil(self.edge * self.tiles) {
            for chunk in self.inputs.chunks(self.edge) {
                let matrices = (0..taps).flat_map(|tap| (0..self.tiles).map(move |of| (tap, of)));
                for ((tap, of), input) in matrices.flat_map(|at| chunk.iter().map(move |input| (at, input))) {
                    let first = (workgroup * self.tiles + of) * self.edge;
                    packed.extend((first..first + self.edge).map(|output| match input {
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

/// Number of output tiles of a workgroup, of `all` tiles. More tiles share more reads; fewer tiles leave fewer of
/// them idle.
fn tiles(all: usize) -> usize {
    let cost = |tiles: &usize| all.div_ceil(*tiles) * (2 * tiles + 1);
    (1..=4).rev().min_by_key(cost).unwrap_or(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn workgroups_share_work_without_waste() {
        assert_eq!([1, 2, 3, 4, 6, 8, 12, 20, 32].map(tiles), [1, 2, 3, 4, 3, 4, 4, 4, 4]);
    }

    #[test]
    fn weights_lie_in_the_order_of_their_use() {
        // Two input tensors of three channels and of one, each beginning a block; nine outputs.
        let weights: Vec<f32> = (0..9 * 4).map(|i| i as f32 + 1.0).collect();
        let packing = Packing::new(BLOCK, 1, &[3, 1], 9);
        let packed = packing.packed(&weights);
        // Three blocks of outputs by two of inputs.
        assert_eq!((packing.tiles, packed.len()), (3, 6 * BLOCK * BLOCK));
        // Output 1, input 2: second lane of the third row of the first block.
        assert_eq!(packed[2 * BLOCK + 1], weights[4 + 2]);
        // The fourth row has no input.
        assert_eq!(packed[3 * BLOCK..4 * BLOCK], [0.0; 4]);
        let sum: f32 = packed.iter().sum();
        assert_eq!(sum, weights.iter().sum::<f32>());
    }

    #[test]
    fn tiles_may_be_wider_than_blocks() {
        // Input tensors of three and of two channels take eight lanes, which is one matrix; nine outputs take two.
        let weights: Vec<f32> = (0..9 * 5 * 9).map(|i| i as f32 + 1.0).collect();
        let packing = Packing::new(8, 3, &[3, 2], 9);
        let packed = packing.packed(&weights);
        assert_eq!((packing.tiles, packed.len()), (2, 9 * 2 * 64));
        // Tap 7, output 8, which begins the second matrix; input 4 is the sixth lane.
        assert_eq!(packed[(7 * 2 + 1) * 64 + 5 * 8], weights[(8 * 5 + 4) * 9 + 7]);
        assert_eq!(packed.iter().filter(|weight| **weight != 0.0).count(), weights.len());
    }
}
