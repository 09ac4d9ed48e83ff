//! Predicted kernels: the 1×1 convolution, the normalisation and the weighted sum for a few rows at a time, so that the
//! kernels of a whole frame never exist.
//!
//! A pixel is read and written as a vector of four numbers, the last of which is the next pixel's first: so numbers need
//! not change places for vectors.

use super::conv::{self, Arithmetic, ConvShape, PreparedConv};
use super::map::{Map, Stored};
use super::patch::{Access, Memory, Source, Window, assemble};
use super::simd::{Simd, Work};
use crate::plan::{Activation, Filter, Normalisation, Padding, SQUARED_EPSILON, Taps};
use glam::Vec4;
use rayon::prelude::*;

/// A predicted kernel with its weights.
#[derive(Debug, Clone)]
pub struct PreparedFilter {
    predict: PreparedConv,
    expand: usize,
    taps: Vec<Taps>,
    normalisation: Normalisation,
    simd: Simd,
}

/// Rows of the output that are made at once; even, for features that serve two rows.
const ROWS: usize = 8;
/// Numbers of a pixel: kernels filter pictures.
const CHANNELS: usize = 3;

impl PreparedFilter {
    /// The layer `filter` with its parameters, which multiplies features as `arithmetic` says.
    pub fn new(
        filter: &Filter,
        (weights, bias): (&[f32], &[f32]),
        simd: Simd,
        arithmetic: Arithmetic,
    ) -> Self {
        let shape = ConvShape {
            inputs: weights.len() / bias.len(),
            outputs: bias.len(),
            size: 1,
            stride: 1,
            padding: Padding::Zero,
            activation: Activation::None,
        };
        Self {
            predict: PreparedConv::new(&shape, weights, bias, simd, arithmetic),
            expand: filter.expand,
            taps: filter.images.iter().map(|&(_, taps)| taps).collect(),
            normalisation: filter.normalisation,
            simd,
        }
    }

    /// Writes the filtered `images`, of three channels, to `out`, whose buffer is used again.
    pub fn run(&self, features: &Stored, images: &[Source<'_>], out: &mut Map) {
        let [height, width] = images[0].size();
        out.resize([height, width, CHANNELS]);
        let bands = out.data.par_chunks_mut(ROWS * width * CHANNELS).enumerate();
        bands.for_each_init(Scratch::default, |scratch, (band, out)| {
            self.band(features, images, band * ROWS, scratch, out);
        });
    }

    /// Filters the rows `out` from `y` on.
    fn band(
        &self,
        features: &Stored,
        images: &[Source<'_>],
        y: usize,
        scratch: &mut Scratch,
        out: &mut [f32],
    ) {
        let width = images[0].size()[1];
        let length = width * CHANNELS;
        let rows = out.len() / length;
        scratch.patches.resize_with(images.len(), Vec::new);
        for (image, patch) in images.iter().zip(&mut scratch.patches) {
            let window = Window { y: y as isize - 1, x: -1, rows: rows + 2, columns: width + 2 };
            let memory = (self.simd, &mut scratch.memory);
            assemble(std::slice::from_ref(image), Padding::Zero, window, patch, memory);
            // What is read beyond the last pixel.
            patch.push(0.0);
        }
        let outputs = self.predict.outputs();
        let stride = length + 2 * CHANNELS;
        scratch.kernels.resize(width / self.expand * outputs, 0.0);
        for row in (0..rows).step_by(self.expand) {
            let features = [Source { map: features, access: Access::SAME }];
            self.predict.rows(&features, (y + row) / self.expand, &mut scratch.conv, &mut scratch.kernels);
            let kernels = &mut scratch.kernels[..];
            self.simd.vectorised(Shaping { filter: self, kernels: &mut *kernels });
            for (line, out) in out[row * length..].chunks_mut(length).take(self.expand).enumerate() {
                let of_image = |patch| Rows { patch, first: (row + line) * stride, stride };
                let images: Vec<Rows<'_>> = scratch.patches.iter().map(|patch| of_image(patch)).collect();
                self.simd.vectorised(Weighing { filter: self, line, kernels, images: &images, out });
            }
        }
    }

    /// The weights of the pixels that feature `x` serves in line `line`, from the first one on.
    #[inline(always)]
    fn weights<'a>(&self, kernels: &'a [f32], x: usize, line: usize) -> &'a [f32] {
        let outputs = self.predict.outputs();
        &kernels[x * outputs..(x + 1) * outputs][line * self.expand..]
    }
}

/// The turning of predictions to weights.
struct Shaping<'a> {
    filter: &'a PreparedFilter,
    /// \[feature\]\[tap\]\[pixel of those that the feature serves\].
    kernels: &'a mut [f32],
}

impl Work for Shaping<'_> {
    #[inline(always)]
    fn run(self) {
        if self.filter.normalisation == Normalisation::Squared {
            self.kernels.iter_mut().for_each(|w| *w = *w * *w + SQUARED_EPSILON);
            return;
        }
        let pixels = self.filter.expand * self.filter.expand;
        for kernels in self.kernels.chunks_exact_mut(self.filter.predict.outputs()) {
            for pixel in 0..pixels {
                let most = kernels[pixel..].iter().step_by(pixels).fold(f32::NEG_INFINITY, |a, &b| a.max(b));
                kernels[pixel..].iter_mut().step_by(pixels).for_each(|w| *w = (*w - most).exp());
            }
        }
    }
}

/// Three rows of an image with a border of one, the second of which is the row that is filtered.
#[derive(Debug, Clone, Copy)]
struct Rows<'a> {
    patch: &'a [f32],
    /// Where the first one begins.
    first: usize,
    /// From one to the next.
    stride: usize,
}

impl Rows<'_> {
    /// The three pixels of row `dy` around pixel `x`.
    #[inline(always)]
    fn three(&self, dy: usize, x: usize) -> [Vec4; 3] {
        let start = self.first + dy * self.stride + x * CHANNELS;
        let numbers = &self.patch[start..start + 3 * CHANNELS + 1];
        [0, CHANNELS, 2 * CHANNELS].map(|at| Vec4::from_slice(&numbers[at..]))
    }
}

/// The filtering of one row with weights.
struct Weighing<'a> {
    filter: &'a PreparedFilter,
    /// Which of the rows that features serve.
    line: usize,
    kernels: &'a [f32],
    images: &'a [Rows<'a>],
    out: &'a mut [f32],
}

impl Work for Weighing<'_> {
    #[inline(always)]
    fn run(self) {
        match self.filter.expand {
            1 => self.row::<1>(),
            _ => self.row::<2>(),
        }
    }
}

impl Weighing<'_> {
    #[inline(always)]
    fn row<const EXPAND: usize>(self) {
        let Self { filter, line, kernels, images, out } = self;
        for x in 0..out.len() / CHANNELS / EXPAND {
            let weights = filter.weights(kernels, x, line);
            for phase in 0..EXPAND {
                let at = x * EXPAND + phase;
                let mut sum = Sum::default();
                let mut tap = phase;
                for (rows, &taps) in images.iter().zip(&filter.taps) {
                    if taps == Taps::Centre {
                        sum.add(weights[tap], rows.three(1, at)[1]);
                        tap += EXPAND * EXPAND;
                        continue;
                    }
                    let weights = &weights[tap..tap + 8 * EXPAND * EXPAND + 1];
                    for dy in 0..3 {
                        let pixels = rows.three(dy, at);
                        for dx in 0..3 {
                            sum.add(weights[(3 * dy + dx) * EXPAND * EXPAND], pixels[dx]);
                        }
                    }
                    tap += 9 * EXPAND * EXPAND;
                }
                match out[at * CHANNELS..].first_chunk_mut::<4>() {
                    Some(wide) => *wide = sum.mean().to_array(),
                    None => out[at * CHANNELS..].copy_from_slice(&sum.mean().to_array()[..CHANNELS]),
                }
            }
        }
    }
}

/// A weighed sum of pixels.
#[derive(Default)]
struct Sum {
    pixels: Vec4,
    /// That of the weights, in every number.
    weights: Vec4,
}

impl Sum {
    #[inline(always)]
    fn add(&mut self, weight: f32, pixel: Vec4) {
        let weight = Vec4::splat(weight);
        self.pixels += weight * pixel;
        self.weights += weight;
    }

    #[inline(always)]
    fn mean(self) -> Vec4 {
        self.pixels / self.weights
    }
}

/// Memory of one thread.
#[derive(Default)]
struct Scratch {
    conv: conv::Scratch,
    /// Those of a row of features, \[feature\]\[output\].
    kernels: Vec<f32>,
    memory: Memory,
    /// Of each image the rows with a border of one, and a number more.
    patches: Vec<Vec<f32>>,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cpu::plain;
    use crate::plan::{Read, Resize, TensorId};
    use proptest::prelude::*;

    fn map(seed: u64, [height, width]: [usize; 2], channels: usize) -> Map {
        let count = height * width * channels;
        let parameter = crate::plan::Parameter { name: "m".into(), shape: vec![count, 5] };
        let mut data = crate::weights::random::values(&parameter, seed);
        data.truncate(count);
        Map { data: data.into(), height, width, channels, top: 0 }
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
            let images: Vec<(Map, Resize, Taps)> = kinds.iter().enumerate().map(|(i, &(is_small, is_around))| {
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
            let resized: Vec<(Map, Taps)> =
                images.iter().map(|(map, resize, taps)| (plain::resized(map, *resize), *taps)).collect();
            let expected = plain::filter(&kernels, &resized, normalisation);
            let stored: Vec<(Stored, Resize)> =
                images.into_iter().map(|(map, resize, _)| (Stored::F32(map), resize)).collect();
            let sources: Vec<Source<'_>> =
                stored.iter().map(|(map, resize)| Source::new(map, *resize)).collect();
            let mut out = Map::default();
            PreparedFilter::new(&layer, (&weights, &bias), Simd::best(), Arithmetic::F32)
                .run(&Stored::F32(features), &sources, &mut out);
            for (a, b) in out.data.iter().zip(&expected.data) {
                prop_assert!((a - b).abs() <= 1e-4, "{a} and {b}");
            }
        }
    }
}
