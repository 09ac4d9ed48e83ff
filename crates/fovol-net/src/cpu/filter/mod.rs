//! Predicted kernels. Prediction, normalisation and weighted sum run for one row of features at a time, so the
//! kernels of a whole frame never exist.
//!
//! Pictures are split into planes, one for each colour and each position within the square that a feature serves
//! ([`planes`]). Kernels are split into taps ([`weigh`]). Each vector lane then handles another feature.

mod planes;
mod prepared;
mod weigh;

use crate::cpu::conv::patch::{Memory, Source};
use crate::cpu::conv::prediction::{Chunk, Prediction};
use crate::cpu::engine::frames::show;
use crate::cpu::layers::pointwise::{Change, change_row};
use crate::cpu::tensor::{AnyTensor, Tensor};
use crate::plan::Filter;
use fovol_core::Frame;
use fovol_simd::Simd;
pub use prepared::PreparedFilter;

use planes::{CHANNELS, Ring, rows_for};
use rayon::prelude::*;
use weigh::Weighing;

/// Parameters of a 1×1 convolution: weights \[out, in\] and biases \[out\].
pub type Parameters<'a> = (&'a [f32], &'a [f32]);

/// Output rows of a task; even, because a feature may serve two rows.
const ROWS: usize = 16;

impl PreparedFilter {
    /// Prepares the layer `filter` with its parameters. With an `addition`, a second 1×1 convolution of the
    /// features predicts three values for each pixel, which are added to the filtered picture.
    pub fn new(
        filter: &Filter,
        (weights, bias): Parameters<'_>,
        addition: Option<Parameters<'_>>,
        simd: Simd,
    ) -> Self {
        let (more_weights, more_bias) = addition.unwrap_or_default();
        Self {
            prediction: Prediction::new(&[weights, more_weights].concat(), &[bias, more_bias].concat()),
            weights: bias.len(),
            has_addition: addition.is_some(),
            expand: filter.expand,
            taps: filter.images.iter().map(|&(_, taps)| taps).collect(),
            normalisation: filter.normalisation,
            simd,
        }
    }

    /// Filters `images`, of three channels, applies `changes` and writes to `out`.
    pub fn run(&self, features: &AnyTensor, images: &[Source<'_>], changes: &[Change<'_>], out: Out<'_>) {
        let [height, width] = images[0].size();
        let length = width * CHANNELS;
        out.bands([height, length]).into_par_iter().enumerate().for_each_init(
            Scratch::default,
            |scratch, (number, band)| {
                scratch.images.resize_with(images.len(), Ring::default);
                scratch.images.iter_mut().for_each(Ring::forget);
                let mut rows = std::mem::take(&mut scratch.rows);
                let first = number * ROWS;
                let count = ROWS.min(height - first);
                rows.resize(if band.picture.is_none() { count * length } else { 0 }, 0.0);
                let out = band.picture.unwrap_or(&mut rows);
                for (cell, out) in out.chunks_mut(self.expand * length).enumerate() {
                    let y = first + cell * self.expand;
                    self.cells(features, images, y, scratch, out);
                    for (line, row) in out.chunks_mut(length).enumerate() {
                        change_row(changes, y + line, CHANNELS, row);
                    }
                }
                let shown = band.frame.into_iter().flat_map(|(pixels, width)| pixels.chunks_mut(width));
                out.chunks(length).zip(shown).for_each(|(row, to)| show(row, to));
                scratch.rows = rows;
            },
        );
    }

    /// Filters the rows `out` from `y` on, which one row of features serves.
    fn cells(
        &self,
        features: &AnyTensor,
        images: &[Source<'_>],
        y: usize,
        Scratch { memory, images: rings, chunk, .. }: &mut Scratch,
        out: &mut [f32],
    ) {
        for ((image, ring), taps) in images.iter().zip(&mut *rings).zip(&self.taps) {
            ring.hold(image, rows_for(*taps, y, self.expand), self.expand, (self.simd, &mut *memory));
        }
        let width = images[0].size()[1];
        self.simd.in_vectors(Weighing { filter: self, y, width, features, images: rings, chunk, out });
    }
}

/// Destination of a filtered picture: a tensor, whose buffer is reused, a frame, or both. The picture may be larger
/// than the frame at the right and bottom.
#[derive(Debug, Default)]
pub struct Out<'a> {
    /// Tensor.
    pub picture: Option<&'a mut Tensor>,
    /// Frame.
    pub frame: Option<&'a mut Frame>,
}

/// [`ROWS`] rows of the destination.
struct Band<'a> {
    picture: Option<&'a mut [f32]>,
    /// Pixels of the frame, and its width.
    frame: Option<(&'a mut [[f32; 4]], usize)>,
}

impl<'a> Out<'a> {
    /// Splits a destination of `height` rows of `length` elements into bands.
    fn bands(self, [height, length]: [usize; 2]) -> Vec<Band<'a>> {
        let mut picture = self.picture.map(|picture| {
            picture.resize([height, length / CHANNELS, CHANNELS]);
            picture.data.chunks_mut(ROWS * length)
        });
        let mut frame = self.frame.map(|frame| {
            let width = frame.size().width as usize;
            (frame.pixels_mut().chunks_mut(ROWS * width), width)
        });
        let band = |_| Band {
            picture: picture.as_mut().and_then(Iterator::next),
            frame: frame.as_mut().and_then(|(rows, width)| Some((rows.next()?, *width))),
        };
        (0..height.div_ceil(ROWS)).map(band).collect()
    }
}

/// Scratch memory of one thread.
#[derive(Default)]
struct Scratch {
    /// Filtered rows that go only to the frame.
    rows: Vec<f32>,
    memory: Memory,
    /// Rows of each image within the windows of the kernels.
    images: Vec<Ring>,
    chunk: Chunk,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cpu::conv::ConvShape;
    use crate::cpu::plain;
    use crate::plan::{Activation, Normalisation, Padding, Read, Resize, Taps, TensorId};
    use fovol_core::FrameSize;
    use proptest::prelude::*;

    fn map(seed: u64, [height, width]: [usize; 2], channels: usize) -> Tensor {
        let count = height * width * channels;
        let parameter = crate::plan::Parameter { name: "m".into(), shape: vec![count, 5] };
        let mut data = crate::weights::random::values(&parameter, seed);
        data.truncate(count);
        Tensor { data: data.into(), height, width, channels }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn fast_filters_are_as_plain_ones(
            half in prop::array::uniform2(1usize..12),
            expand in 1usize..3,
            is_softmax in prop::bool::ANY,
            kinds in prop::collection::vec((prop::bool::ANY, prop::bool::ANY), 1..4),
            seed in any::<u64>(),
        ) {
            let size = half.map(|side| 2 * side);
            let normalisation = if is_softmax { Normalisation::Softmax } else { Normalisation::Squared };
            let images: Vec<(Tensor, Resize, Taps)> = kinds.iter().enumerate().map(|(i, &(is_small, is_around))| {
                let resize = if is_small { Resize::Bilinear } else { Resize::Same };
                let taps = if is_around { Taps::Around } else { Taps::Centre };
                (map(seed ^ i as u64, if is_small { half } else { size }, 3), resize, taps)
            }).collect();
            let taps: usize = images.iter().map(|(_, _, taps)| taps.count()).sum();
            let features = map(seed ^ 9, size.map(|side| side / expand), 7);
            let outputs = taps * expand * expand;
            let (weights, bias) = (map(seed ^ 10, [outputs, 7], 1).data, map(seed ^ 11, [outputs, 1], 1).data);
            let layer = Filter {
                name: "f".into(),
                features: TensorId(0),
                expand,
                images: images.iter().map(|&(_, resize, taps)| (Read { tensor: TensorId(0), resize }, taps)).collect(),
                output: TensorId(0),
                normalisation,
            };
            let shape = ConvShape {
                inputs: 7, outputs, size: 1, stride: 1, padding: Padding::Zero, activation: Activation::None,
            };
            let kernels = plain::conv(&shape, &weights, &bias, &features);
            let resized: Vec<(Tensor, Taps)> =
                images.iter().map(|(map, resize, taps)| (plain::resized(map, *resize), *taps)).collect();
            let expected = plain::filter(&kernels, &resized, normalisation);
            let stored: Vec<(AnyTensor, Resize)> =
                images.into_iter().map(|(map, resize, _)| (AnyTensor::F32(map), resize)).collect();
            let sources: Vec<Source<'_>> =
                stored.iter().map(|(map, resize)| Source::new(map, *resize)).collect();
            let mut out = Tensor::default();
            // The frame lacks the last row and the last column of the picture.
            let frame_size = FrameSize { width: size[1] as u32 - 1, height: size[0] as u32 - 1 };
            let [mut frame, mut alone] = [(); 2].map(|()| Frame::new(frame_size));
            let filter = PreparedFilter::new(&layer, (&weights, &bias), None, Simd::best());
            let features = AnyTensor::F32(features);
            filter.run(&features, &sources, &[], Out { picture: Some(&mut out), frame: Some(&mut frame) });
            filter.run(&features, &sources, &[], Out { picture: None, frame: Some(&mut alone) });
            prop_assert_eq!(&frame, &alone);
            for (at, &[r, g, b, a]) in frame.pixels().iter().enumerate() {
                let [y, x] = [at / frame_size.width as usize, at % frame_size.width as usize];
                let expected: Vec<f32> = out.pixel(y, x).iter().map(|v| v.clamp(0.0, 1.0)).collect();
                prop_assert_eq!((&[r, g, b][..], a), (&expected[..], 1.0));
            }
            for (a, b) in out.data.iter().zip(&expected.data) {
                prop_assert!((a - b).abs() <= 1e-4, "{a} and {b}");
            }
        }
    }
}
