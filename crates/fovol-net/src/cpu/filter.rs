//! Predicted kernels: the 1×1 convolution, the normalisation and the weighted sum for a few rows at a time, so
//! that the kernels of a whole frame never exist.

use super::conv::{Arithmetic, ConvShape, Direct};
use super::map::{Map, Stored};
use super::patch::{Source, Window, assemble};
use super::simd::{Simd, Work};
use crate::plan::{Activation, Filter, Normalisation, Padding, SQUARED_EPSILON, Taps};
use rayon::prelude::*;

/// A predicted kernel with its weights.
#[derive(Debug, Clone)]
pub struct PreparedFilter {
    conv: Direct,
    expand: usize,
    taps: Vec<Taps>,
    normalisation: Normalisation,
    simd: Simd,
}

/// Rows of the output that are made at once; even, for features that serve two rows.
const ROWS: usize = 8;

impl PreparedFilter {
    /// The layer `filter` over `inputs` feature channels with its parameters.
    pub fn new(
        filter: &Filter,
        inputs: usize,
        (weights, bias): (&[f32], &[f32]),
        simd: Simd,
        arithmetic: Arithmetic,
    ) -> Self {
        let shape = ConvShape {
            inputs,
            outputs: bias.len(),
            size: 1,
            stride: 1,
            padding: Padding::Zero,
            activation: Activation::None,
        };
        Self {
            conv: Direct::new(&shape, weights, bias, simd, arithmetic),
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
            let y = band * ROWS;
            let rows = out.len() / (width * channels);
            self.conv.run_rows(features, y / self.expand, rows.div_ceil(self.expand), &mut scratch.kernels);
            let size = [y, rows, width, channels];
            self.simd.vectorised(Band { filter: self, images, size, scratch, out });
        });
    }

    /// Filters `rows` rows from `y` on with the kernels in `scratch`.
    #[inline(always)]
    fn band(
        &self,
        images: &[Source<'_>],
        [y, rows, width, channels]: [usize; 4],
        scratch: &mut Scratch,
        out: &mut [f32],
    ) {
        self.normalise(scratch, rows, width);
        scratch.sums.clear();
        scratch.sums.resize(rows * channels * width, 0.0);
        let mut first = 0;
        for (image, &taps) in images.iter().zip(&self.taps) {
            let window = Window { y: y as isize - 1, x: -1, rows: rows + 2, columns: width + 2 };
            assemble(std::slice::from_ref(image), Padding::Zero, window, &mut scratch.patch);
            apart(&scratch.patch, channels, width + 2, &mut scratch.planes);
            self.apply(scratch, first, taps, [width, channels]);
            first += taps.count();
        }
        together(&scratch.sums, channels, width, out);
    }

    /// Brings the predicted weights of `rows` × `width` pixels to a sum of 1: \[row\]\[tap\]\[column\].
    #[inline(always)]
    fn normalise(&self, scratch: &mut Scratch, rows: usize, width: usize) {
        let count: usize = self.taps.iter().map(|taps| taps.count()).sum();
        let (kernels, expand) = (&scratch.kernels, self.expand);
        scratch.weights.resize(rows * count * width, 0.0);
        scratch.totals.resize(width, 0.0);
        for (y, weights) in scratch.weights.chunks_exact_mut(count * width).enumerate() {
            let row = kernels.row(y / expand);
            for x in 0..width {
                let part = (y % expand) * expand + x % expand;
                let from = row[x / expand * kernels.channels + part..].iter().step_by(expand * expand);
                weights[x..].iter_mut().step_by(width).zip(from).for_each(|(to, &w)| *to = w);
            }
            self.shape(weights, &mut scratch.totals, width);
        }
    }

    /// Turns predictions of one row, \[tap\]\[column\], to weights.
    #[inline(always)]
    fn shape(&self, weights: &mut [f32], totals: &mut [f32], width: usize) {
        match self.normalisation {
            Normalisation::Squared => weights.iter_mut().for_each(|w| *w = *w * *w + SQUARED_EPSILON),
            Normalisation::Softmax => {
                totals.fill(f32::NEG_INFINITY);
                for row in weights.chunks_exact(width) {
                    totals.iter_mut().zip(row).for_each(|(most, &w)| *most = most.max(w));
                }
                for row in weights.chunks_exact_mut(width) {
                    row.iter_mut().zip(&*totals).for_each(|(w, &most)| *w = (*w - most).exp());
                }
            }
        }
        totals.fill(0.0);
        for row in weights.chunks_exact(width) {
            totals.iter_mut().zip(row).for_each(|(sum, &w)| *sum += w);
        }
        totals.iter_mut().for_each(|sum| *sum = 1.0 / *sum);
        for row in weights.chunks_exact_mut(width) {
            row.iter_mut().zip(&*totals).for_each(|(w, &scale)| *w *= scale);
        }
    }

    /// Adds the image in the planes, weighed from weight `first` on, to the sums.
    #[inline(always)]
    fn apply(&self, scratch: &mut Scratch, first: usize, taps: Taps, [width, channels]: [usize; 2]) {
        let count: usize = self.taps.iter().map(|taps| taps.count()).sum();
        for (row, sums) in scratch.sums.chunks_exact_mut(width).enumerate() {
            let (y, c) = (row / channels, row % channels);
            for k in 0..taps.count() {
                let (dy, dx) = if taps == Taps::Around { (k / 3, k % 3) } else { (1, 1) };
                let from = &scratch.planes[((y + dy) * channels + c) * (width + 2) + dx..][..width];
                let weights = &scratch.weights[(y * count + first + k) * width..][..width];
                for ((sum, &v), &w) in sums.iter_mut().zip(from).zip(weights) {
                    *sum += w * v;
                }
            }
        }
    }
}

/// \[row\]\[column\]\[channel\] to \[row\]\[channel\]\[column\]: columns side by side fill vectors.
#[inline(always)]
fn apart(image: &[f32], channels: usize, width: usize, planes: &mut Vec<f32>) {
    planes.resize(image.len(), 0.0);
    let rows = image.chunks_exact(width * channels).zip(planes.chunks_exact_mut(width * channels));
    for (from, to) in rows {
        for (c, to) in to.chunks_exact_mut(width).enumerate() {
            to.iter_mut().zip(from[c..].iter().step_by(channels)).for_each(|(to, &v)| *to = v);
        }
    }
}

/// The inverse of [`apart`].
#[inline(always)]
fn together(planes: &[f32], channels: usize, width: usize, image: &mut [f32]) {
    let rows = planes.chunks_exact(width * channels).zip(image.chunks_exact_mut(width * channels));
    for (from, to) in rows {
        for (c, from) in from.chunks_exact(width).enumerate() {
            to[c..].iter_mut().step_by(channels).zip(from).for_each(|(to, &v)| *to = v);
        }
    }
}

/// The filtering of some rows.
struct Band<'a> {
    filter: &'a PreparedFilter,
    images: &'a [Source<'a>],
    /// The first row, rows, columns, channels.
    size: [usize; 4],
    scratch: &'a mut Scratch,
    out: &'a mut [f32],
}

impl Work for Band<'_> {
    #[inline(always)]
    fn run(self) {
        self.filter.band(self.images, self.size, self.scratch, self.out);
    }
}

/// Memory of one thread.
#[derive(Default)]
struct Scratch {
    kernels: Map,
    /// \[row\]\[tap\]\[column\].
    weights: Vec<f32>,
    /// Sums of the weights of each column.
    totals: Vec<f32>,
    patch: Vec<f32>,
    /// The patch as \[row\]\[channel\]\[column\].
    planes: Vec<f32>,
    /// The filtered image as \[row\]\[channel\]\[column\].
    sums: Vec<f32>,
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
        Map { data, height, width, channels }
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
                stored.iter().map(|(map, resize)| Source { map, resize: *resize }).collect();
            let mut out = Map::default();
            PreparedFilter::new(&layer, 7, (&weights, &bias), Simd::best(), Arithmetic::F32)
                .run(&Stored::F32(features), &sources, &mut out);
            for (a, b) in out.data.iter().zip(&expected.data) {
                prop_assert!((a - b).abs() <= 1e-4, "{a} and {b}");
            }
        }
    }
}
