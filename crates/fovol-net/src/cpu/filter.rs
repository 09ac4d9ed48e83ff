//! Predicted kernels: the 1×1 convolution, the normalisation and the weighted sum for a few rows and columns at a time,
//! so that the kernels of a whole frame never exist.
//!
//! Everything is computed with columns side by side in vectors. Where a feature serves several columns, the columns
//! that features serve first come first, then those that they serve second: the phases of a row.

use super::conv::{self, Arithmetic, ConvShape, PreparedConv};
use super::map::{Map, Stored};
use super::patch::{Access, Memory, Source, Window, assemble};
use super::simd::{Simd, Work};
use crate::plan::{Activation, Filter, Normalisation, Padding, SQUARED_EPSILON, Taps};
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
/// Features whose kernels are made at once: as many as fit into the nearest cache with all their numbers.
const COLUMNS: usize = 64;

/// A number of each feature.
type Lanes = [f32; COLUMNS];

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

    /// Writes the filtered `images` to `out`, whose buffer is used again.
    pub fn run(&self, features: &Stored, images: &[Source<'_>], out: &mut Map) {
        let [height, width] = images[0].size();
        let channels = images[0].map.channels();
        out.resize([height, width, channels]);
        let bands = out.data.par_chunks_mut(ROWS * width * channels).enumerate();
        bands.for_each_init(Scratch::default, |scratch, (band, out)| {
            let size = [band * ROWS, out.len() / (width * channels), width, channels];
            self.simd.vectorised(Band { filter: self, features, images, size, scratch, out });
        });
    }

    /// Filters `rows` rows from `y` on.
    #[inline(always)]
    fn band<const EXPAND: usize>(
        &self,
        features: &Stored,
        images: &[Source<'_>],
        [y, rows, width, channels]: [usize; 4],
        scratch: &mut Scratch,
        out: &mut [f32],
    ) {
        let columns = width / EXPAND;
        scratch.planes.resize_with(images.len(), Planes::default);
        for (image, planes) in images.iter().zip(&mut scratch.planes) {
            let window = Window { y: y as isize - 1, x: -1, rows: rows + 2, columns: width + 2 };
            let memory = (self.simd, &mut scratch.memory);
            assemble(std::slice::from_ref(image), Padding::Zero, window, &mut scratch.patch, memory);
            planes.fill::<EXPAND>(&scratch.patch, channels, width + 2);
        }
        let outputs = self.predict.outputs();
        scratch.predicted.resize(columns * outputs, 0.0);
        scratch.kernels.resize(outputs, [0.0; COLUMNS]);
        for row in 0..rows.div_ceil(EXPAND) {
            let features = [Source { map: features, access: Access::SAME }];
            self.predict.rows(&features, y / EXPAND + row, &mut scratch.conv, &mut scratch.predicted);
            for first in (0..columns).step_by(COLUMNS) {
                let count = COLUMNS.min(columns - first);
                transpose(&scratch.predicted[first * outputs..][..count * outputs], &mut scratch.kernels);
                for part in 0..EXPAND * EXPAND {
                    let share = self.shape::<EXPAND>(part, &mut scratch.kernels);
                    let (line, phase) = (row * EXPAND + part / EXPAND, part % EXPAND);
                    let to = &mut out[line * width * channels..][..width * channels];
                    for c in 0..channels {
                        let place = Place { row: line, channel: c, phase, first };
                        let sums = self.weighed::<EXPAND>(part, place, &scratch.planes, &scratch.kernels);
                        let to = to[(first * EXPAND + phase) * channels + c..].iter_mut();
                        let to = to.step_by(EXPAND * channels).take(count);
                        for (to, (sum, share)) in to.zip(sums.iter().zip(&share)) {
                            *to = sum * share;
                        }
                    }
                }
            }
        }
    }

    /// Turns the predictions for pixel `part` of those that a feature serves to weights; what these are to be multiplied
    /// by for a sum of 1.
    #[inline(always)]
    fn shape<const EXPAND: usize>(&self, part: usize, kernels: &mut [Lanes]) -> Lanes {
        let pixels = EXPAND * EXPAND;
        let mut total = [0.0f32; COLUMNS];
        if self.normalisation == Normalisation::Softmax {
            let mut most = [f32::NEG_INFINITY; COLUMNS];
            for kernel in kernels[part..].iter().step_by(pixels) {
                for i in 0..COLUMNS {
                    most[i] = most[i].max(kernel[i]);
                }
            }
            for kernel in kernels[part..].iter_mut().step_by(pixels) {
                for i in 0..COLUMNS {
                    kernel[i] = (kernel[i] - most[i]).exp();
                    total[i] += kernel[i];
                }
            }
        } else {
            for kernel in kernels[part..].iter_mut().step_by(pixels) {
                for i in 0..COLUMNS {
                    kernel[i] = kernel[i] * kernel[i] + SQUARED_EPSILON;
                    total[i] += kernel[i];
                }
            }
        }
        for total in &mut total {
            *total = 1.0 / *total;
        }
        total
    }

    /// The sums of all images at `place`, weighed by the kernels of `part`.
    #[inline(always)]
    fn weighed<const EXPAND: usize>(
        &self,
        part: usize,
        place: Place,
        planes: &[Planes],
        kernels: &[Lanes],
    ) -> Lanes {
        let mut sums = [0.0f32; COLUMNS];
        let mut kernels = kernels[part..].iter().step_by(EXPAND * EXPAND);
        for (planes, &taps) in planes.iter().zip(&self.taps) {
            let window = if taps == Taps::Around { [0, 1, 2].as_slice() } else { [1].as_slice() };
            for &dy in window {
                for &dx in window {
                    let from = planes.lanes::<EXPAND>(place, [dy, dx]);
                    let Some(weights) = kernels.next() else { return sums };
                    for i in 0..COLUMNS {
                        sums[i] += weights[i] * from[i];
                    }
                }
            }
        }
        sums
    }
}

/// Which pixels of a band are summed.
#[derive(Debug, Clone, Copy)]
struct Place {
    row: usize,
    channel: usize,
    /// Which of the columns that each feature serves.
    phase: usize,
    /// The first of [`COLUMNS`] features.
    first: usize,
}

/// A part of an image with a border of one, \[row\]\[channel\]\[phase\]\[column\].
#[derive(Debug, Default)]
struct Planes {
    data: Vec<f32>,
    channels: usize,
    /// Numbers of a phase, with room for lanes beyond the last column.
    length: usize,
}

impl Planes {
    /// Takes over `image`, \[row\]\[column\]\[channel\].
    #[inline(always)]
    fn fill<const PHASES: usize>(&mut self, image: &[f32], channels: usize, width: usize) {
        let rows = image.len() / (width * channels);
        self.channels = channels;
        self.length = width.div_ceil(PHASES).next_multiple_of(COLUMNS) + COLUMNS;
        self.data.resize(rows * channels * PHASES * self.length, 0.0);
        let lines = self.data.chunks_exact_mut(channels * PHASES * self.length);
        for (from, to) in image.chunks_exact(width * channels).zip(lines) {
            for (plane, to) in to.chunks_exact_mut(self.length).enumerate() {
                let first = plane % PHASES * channels + plane / PHASES;
                pick(from, first, PHASES * channels, to);
            }
        }
    }

    /// What the pixels at `place` find at row `dy` and column `dx` of the 3×3 around them.
    #[inline(always)]
    fn lanes<const PHASES: usize>(&self, place: Place, [dy, dx]: [usize; 2]) -> &Lanes {
        let at = place.phase + dx;
        let plane = ((place.row + dy) * self.channels + place.channel) * PHASES + at % PHASES;
        let start = plane * self.length + place.first + at / PHASES;
        self.data[start..].first_chunk().expect("planes have room for lanes beyond the last column")
    }
}

/// Turns `from`, \[column\]\[output\], to \[output\]\[column\].
#[inline(always)]
fn transpose(from: &[f32], to: &mut [Lanes]) {
    let outputs = to.len();
    for (output, to) in to.iter_mut().enumerate() {
        for (to, pixel) in to.iter_mut().zip(from.chunks_exact(outputs)) {
            *to = pixel[output];
        }
    }
}

/// Every `stride`-th number of `from` from `first` on.
#[inline(always)]
fn pick(from: &[f32], first: usize, stride: usize, to: &mut [f32]) {
    let count = from.len().saturating_sub(first).div_ceil(stride);
    for (i, to) in to[..count].iter_mut().enumerate() {
        *to = from[first + i * stride];
    }
}

/// The filtering of some rows.
struct Band<'a> {
    filter: &'a PreparedFilter,
    features: &'a Stored,
    images: &'a [Source<'a>],
    /// The first row, rows, columns, channels.
    size: [usize; 4],
    scratch: &'a mut Scratch,
    out: &'a mut [f32],
}

impl Work for Band<'_> {
    #[inline(always)]
    fn run(self) {
        let Self { filter, features, images, size, scratch, out } = self;
        match filter.expand {
            1 => filter.band::<1>(features, images, size, scratch, out),
            _ => filter.band::<2>(features, images, size, scratch, out),
        }
    }
}

/// Memory of one thread.
#[derive(Default)]
struct Scratch {
    conv: conv::Scratch,
    /// A row of features' kernels, \[column\]\[output\].
    predicted: Vec<f32>,
    /// Some of them, by output.
    kernels: Vec<Lanes>,
    patch: Vec<f32>,
    memory: Memory,
    /// Of each image.
    planes: Vec<Planes>,
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
