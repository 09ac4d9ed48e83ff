use super::super::simd::Work;
use super::PreparedFilter;
use super::planes::{CHANNELS, Ring};
use crate::plan::{Normalisation, SQUARED_EPSILON, Taps};
use glam::{Mat4, Vec4};

/// Features that are done at once: the numbers of the longest vectors.
pub const LANES: usize = 16;

/// A number of each of them.
type Lanes = [f32; LANES];

/// What is on its way for these features.
#[derive(Debug, Default)]
pub struct Chunk {
    /// \[output of the prediction\], the weights of kernels and what is added.
    predicted: Vec<Lanes>,
}

/// The filtering of the rows that one row of features serves.
pub struct Weighing<'a> {
    pub filter: &'a PreparedFilter,
    /// The first of these rows.
    pub y: usize,
    /// Their pixels.
    pub width: usize,
    /// \[feature\]\[output of the prediction\].
    pub kernels: &'a [f32],
    pub images: &'a [Ring],
    pub chunk: &'a mut Chunk,
    pub out: &'a mut [f32],
}

impl Work for Weighing<'_> {
    #[inline(always)]
    fn run(self) {
        match self.filter.expand {
            1 => self.rows::<1, { CHANNELS }>(),
            _ => self.rows::<2, { 2 * CHANNELS }>(),
        }
    }
}

impl Weighing<'_> {
    /// `N`: numbers of the pixels of one row that a feature serves.
    #[inline(always)]
    fn rows<const EXPAND: usize, const N: usize>(self) {
        let Self { filter, y, width, kernels, images, chunk, out } = self;
        let predicted = &mut chunk.predicted;
        for first in (0..width / EXPAND).step_by(LANES) {
            transpose(&kernels[first * filter.predict.outputs()..], filter.predict.outputs(), predicted);
            let weights = filter.taps.iter().map(|taps| taps.count()).sum::<usize>() * EXPAND * EXPAND;
            let (weights, addition) = predicted.split_at_mut(weights);
            shape::<EXPAND>(filter.normalisation, weights);
            for line in 0..EXPAND {
                let mut pixels = [[0.0; LANES]; N];
                for phase in 0..EXPAND {
                    let mut sum = Sum::default();
                    let mut weights = weights[line * EXPAND + phase..].iter().step_by(EXPAND * EXPAND);
                    for (image, &taps) in images.iter().zip(&filter.taps) {
                        for (row, columns) in places(taps) {
                            let row = image.row(y + line + row);
                            for column in columns {
                                let at = phase + EXPAND + column - 1;
                                let Some(weight) = weights.next() else { return };
                                let from = first + at / EXPAND;
                                let colours = std::array::from_fn(|c| lanes(row.of(c, at % EXPAND), from));
                                sum.add(weight, colours);
                            }
                        }
                    }
                    for (c, mut mean) in sum.mean().into_iter().enumerate() {
                        if filter.has_addition {
                            let more = &addition[(c * EXPAND + line) * EXPAND + phase];
                            (0..LANES).for_each(|i| mean[i] += more[i]);
                        }
                        pixels[phase * CHANNELS + c] = mean;
                    }
                }
                let row = &mut out[line * width * CHANNELS..][..width * CHANNELS];
                join(&pixels, &mut row[first * N..]);
            }
        }
    }
}

/// Rows, and columns of them, that `taps` look at, in the order of their weights; 1 is where the pixel itself is.
#[inline(always)]
fn places(taps: Taps) -> impl Iterator<Item = (usize, std::ops::Range<usize>)> {
    let around = match taps {
        Taps::Around => 0..3,
        Taps::Centre => 1..2,
    };
    around.clone().map(move |row| (row, around.clone()))
}

/// The numbers of a plane from `first` on.
#[inline(always)]
fn lanes(plane: &[f32], first: usize) -> &Lanes {
    plane[first..].first_chunk().expect("planes go on beyond the last pixel")
}

/// Makes `to` the `outputs` of the first features of `kernels`, which has some numbers more than these.
#[inline(always)]
fn transpose(kernels: &[f32], outputs: usize, to: &mut Vec<Lanes>) {
    to.resize(outputs.next_multiple_of(4), [0.0; LANES]);
    for feature in (0..LANES).step_by(4) {
        for (four, to) in to.as_chunks_mut::<4>().0.iter_mut().enumerate() {
            let of = |i: usize| {
                let from = (feature + i) * outputs + 4 * four;
                kernels.get(from..from + 4).map_or(Vec4::ZERO, Vec4::from_slice)
            };
            let columns = Mat4::from_cols(of(0), of(1), of(2), of(3)).transpose().to_cols_array_2d();
            for (to, column) in to.iter_mut().zip(columns) {
                to[feature..feature + 4].copy_from_slice(&column);
            }
        }
    }
}

/// Turns predictions to weights, which are still to be divided by their sum.
#[inline(always)]
fn shape<const EXPAND: usize>(normalisation: Normalisation, predicted: &mut [Lanes]) {
    if normalisation == Normalisation::Squared {
        return predicted.as_flattened_mut().iter_mut().for_each(|w| *w = *w * *w + SQUARED_EPSILON);
    }
    let pixels = EXPAND * EXPAND;
    for pixel in 0..pixels {
        let mut most = [f32::NEG_INFINITY; LANES];
        for lanes in predicted[pixel..].iter().step_by(pixels) {
            (0..LANES).for_each(|i| most[i] = most[i].max(lanes[i]));
        }
        for lanes in predicted[pixel..].iter_mut().step_by(pixels) {
            (0..LANES).for_each(|i| lanes[i] = (lanes[i] - most[i]).exp());
        }
    }
}

/// Weighed sums of pixels.
#[derive(Default)]
struct Sum {
    colours: [Lanes; CHANNELS],
    weights: Lanes,
}

impl Sum {
    #[inline(always)]
    fn add(&mut self, weights: &Lanes, colours: [&Lanes; CHANNELS]) {
        for (sum, colour) in self.colours.iter_mut().zip(colours) {
            for i in 0..LANES {
                sum[i] += weights[i] * colour[i];
            }
        }
        (0..LANES).for_each(|i| self.weights[i] += weights[i]);
    }

    #[inline(always)]
    fn mean(self) -> [Lanes; CHANNELS] {
        let Self { mut colours, weights } = self;
        for colour in &mut colours {
            (0..LANES).for_each(|i| colour[i] /= weights[i]);
        }
        colours
    }
}

/// Writes number i of each of `planes`, side by side, to `row`, as far as that goes.
#[inline(always)]
fn join<const N: usize>(planes: &[Lanes; N], row: &mut [f32]) {
    let cells = row.as_chunks_mut::<N>().0;
    for (four, cells) in cells.chunks_mut(4).take(LANES / 4).enumerate() {
        for n in (0..N).step_by(4) {
            let of =
                |i: usize| planes.get(n + i).map_or(Vec4::ZERO, |lanes| Vec4::from_slice(&lanes[4 * four..]));
            let numbers = Mat4::from_cols(of(0), of(1), of(2), of(3)).transpose().to_cols_array_2d();
            for (cell, numbers) in cells.iter_mut().zip(numbers) {
                let count = (N - n).min(4);
                cell[n..n + count].copy_from_slice(&numbers[..count]);
            }
        }
    }
}
