//! Pull-push pyramid: averages weighted pixels over growing squares, and fills gaps from coarser levels.

use crate::cpu::tensor::samples::{PremulRgba, Sample, Samples};
use crate::cpu::tensor::upsampling::halves;
use fovol_simd::{Arithmetic, Pixels, Simd, SimdF32, SimdF32Op};
use glam::Vec4;
use rayon::prelude::*;

/// Lower limit of divisors.
const SMALLEST: f32 = 1e-8;
/// Gain of weights: a mean weight of 1/8 suffices for a full weight at half the resolution.
const GAIN: f32 = 8.0;
/// Number of rows of a task.
const BAND: usize = 8;
/// Smallest number of pixels of a task; smaller tasks cost more than they save.
const SHARED: usize = 1 << 14;
/// Binomial weights of four neighbours.
const BINOMIAL: [f32; 4] = [0.125, 0.375, 0.375, 0.125];

/// Weighted pixels of a frame, computed on demand, row by row.
pub trait KnownRows: Sync {
    /// Scratch memory for computing rows.
    type Memory: Default + Send;

    /// Rows and columns.
    fn size(&self) -> [usize; 2];

    /// Computes row `y` and writes it to `to`.
    fn make(&self, y: usize, memory: &mut Self::Memory, to: &mut Vec<PremulRgba>);
}

/// An image of weighted pixels.
#[derive(Debug, Clone, Default)]
pub struct Level {
    pixels: Vec<PremulRgba>,
    width: usize,
}

impl Level {
    /// Pixels of row `y`.
    pub fn row(&self, y: usize) -> &[PremulRgba] {
        &self.pixels[y * self.width..(y + 1) * self.width]
    }

    fn height(&self) -> usize {
        self.pixels.len() / self.width
    }

    /// Resizes the level; its contents become undefined.
    fn resize(&mut self, [height, width]: [usize; 2]) {
        self.pixels.resize(height * width, [0.0; 4]);
        self.width = width;
    }
}

/// Pyramid of weighted pixels. The first level has half the resolution of the frame, each further level half that
/// of the one before. Memory is reused for every frame.
#[derive(Debug, Clone, Default)]
pub struct Pyramid {
    levels: Vec<Level>,
}

impl Pyramid {
    /// Pulls the first level from the image `known`, `width` pixels wide.
    pub fn pull_from(&mut self, known: &[PremulRgba], width: usize) {
        pull(known, width, self.first());
    }

    /// Pulls the first level from rows that are computed on demand.
    pub fn pull_of<K: KnownRows>(&mut self, known: &K) {
        pull_of(known, self.first());
    }

    /// Pulls the first level from samples alone: `value` gives the weighted pixel of a sample, from its row number
    /// and sample.
    pub fn pull_samples(&mut self, samples: &Samples, value: impl Fn(usize, &Sample) -> Vec4 + Sync) {
        pull_samples(samples, value, self.first());
    }

    /// Fills the level of 2^`lowest` times lower resolution than the frame from levels of up to 2^`levels` times
    /// lower resolution. Then it calls `finish` for each row, with the row number, its pixels and the row of `out`.
    ///
    /// Pulling halves the resolution: premultiplied values c and weights w are averaged over 4×4 pixels by (1, 3,
    /// 3, 1)/8 along both axes, replicated at the border. Then w' = min(8w, 1) and c' = c·w'/max(w, 1e-8). Pushing
    /// goes back: each finer level becomes c' + (1 − w')·(c of the coarser level, bilinear), and likewise its
    /// weight.
    pub fn complete(
        &mut self,
        [levels, lowest]: [u32; 2],
        out: &mut [f32],
        finish: impl Fn(usize, &[PremulRgba], &mut [f32]) + Sync,
    ) {
        let (lowest, levels) = (lowest as usize, levels.max(lowest) as usize);
        self.levels.resize_with(self.levels.len().max(levels), Level::default);
        for level in 1..levels {
            let [finer, coarser] = self.two(level);
            pull(&finer.pixels, finer.width, coarser);
        }
        for level in (lowest + 1..levels).rev() {
            let [finer, coarser] = self.two(level);
            push(finer, coarser);
        }
        let wanted = &self.levels[lowest - 1];
        let coarser = (lowest < levels).then(|| &self.levels[lowest]);
        let length = out.len() / wanted.height();
        let bands = out.par_chunks_mut(BAND * length).enumerate();
        bands.for_each_init(
            Default::default,
            |(row, blended): &mut (Vec<PremulRgba>, Vec<PremulRgba>), (band, out)| {
                for (y, to) in (band * BAND..).zip(out.chunks_exact_mut(length)) {
                    // The last push goes row by row into scratch memory, so that the filled level is never stored.
                    row.clear();
                    row.extend_from_slice(wanted.row(y));
                    if let Some(coarser) = coarser {
                        Simd::best().in_vectors(PushRow { y, row, coarser, blended });
                    }
                    finish(y, row, to);
                }
            },
        );
    }

    fn first(&mut self) -> &mut Level {
        if self.levels.is_empty() {
            self.levels.push(Level::default());
        }
        &mut self.levels[0]
    }

    /// Level `level` − 1 and level `level`.
    fn two(&mut self, level: usize) -> [&mut Level; 2] {
        let (before, from) = self.levels.split_at_mut(level);
        [&mut before[level - 1], &mut from[0]]
    }
}

/// Divides pixels by their weights.
#[inline(always)]
pub fn divided<V: Pixels>(known: V) -> V {
    known * known.fourths().max(known.splat(SMALLEST)).recip()
}

/// Pulls `to`, at half the resolution, from the image `known`, `width` pixels wide.
fn pull(known: &[PremulRgba], width: usize, to: &mut Level) {
    let height = known.len() / width;
    let row = |y: usize| &known[y * width..(y + 1) * width];
    to.resize([height / 2, width / 2]);
    let tasks = to.pixels.par_chunks_exact_mut(width / 2).with_min_len(SHARED / width).enumerate();
    tasks.for_each_init(Vec::new, |blended, (y, to)| {
        let rows = around(y, height).map(row);
        Simd::best().in_vectors(PullRow { rows, blended, to });
    });
}

/// Pulls `to`, at half the resolution, from rows that are computed on demand.
fn pull_of<K: KnownRows>(known: &K, to: &mut Level) {
    let [height, width] = known.size();
    let width = width / 2;
    to.resize([height / 2, width]);
    let bands = to.pixels.par_chunks_mut(BAND * width).enumerate();
    bands.for_each_init(Ring::<K>::default, |ring, (band, rows)| {
        ring.held = [None; 4];
        for (row, to) in rows.chunks_exact_mut(width).enumerate() {
            let wanted = around(band * BAND + row, height);
            wanted.iter().for_each(|&y| ring.hold(known, y));
            let Ring { rows, blended, .. } = ring;
            let rows = wanted.map(|y| &rows[y % 4][..]);
            Simd::best().in_vectors(PullRow { rows, blended, to });
        }
    });
}

/// Pulls `to`, at half the resolution, from samples alone, whose weighted pixels are `value`.
fn pull_samples(samples: &Samples, value: impl Fn(usize, &Sample) -> Vec4 + Sync, to: &mut Level) {
    let [height, width] = samples.size();
    let last = width / 2 - 1;
    to.resize([height / 2, width / 2]);
    to.pixels.par_chunks_exact_mut(width / 2).enumerate().for_each(|(y, to)| {
        to.fill([0.0; 4]);
        for (row, share) in around(y, height).into_iter().zip(BINOMIAL) {
            for sample in samples.row(row) {
                let value = share * value(row, sample);
                // Of four pixels that make one, the sample is the second or third for the pixel in which it lies,
                // and the first or last for another.
                let [(near, wn), (far, wf)] = parts(sample.x as usize, last);
                to[near] = (Vec4::from_array(to[near]) + wn * value).to_array();
                to[far] = (Vec4::from_array(to[far]) + wf * value).to_array();
            }
        }
        Simd::best().in_vectors(NormaliseRow { to });
    });
}

/// The two pixels of half the resolution, up to column `last`, to which pixel `x` contributes, and its weights
/// there.
fn parts(x: usize, last: usize) -> [(usize, f32); 2] {
    let near = x / 2;
    let far = if x.is_multiple_of(2) { near.saturating_sub(1) } else { (near + 1).min(last) };
    [(near.min(last), BINOMIAL[1]), (far.min(last), BINOMIAL[0])]
}

/// Operation that normalises the means of one row.
struct NormaliseRow<'a> {
    to: &'a mut [PremulRgba],
}

impl SimdF32Op for NormaliseRow<'_> {
    type Output = ();

    #[inline(always)]
    fn run<V: SimdF32>(self, some: V) {
        let whole = 4 * self.to.len() / V::N * V::N;
        let (vectors, rest) = self.to.as_flattened_mut().split_at_mut(whole);
        for to in vectors.chunks_exact_mut(V::N) {
            normalised(some.load(to)).store(to);
        }
        for to in rest.chunks_exact_mut(4) {
            normalised(Vec4::from_slice(to)).write_to_slice(to);
        }
    }
}

/// Normalises means over 4×4 pixels to pixels of half the resolution.
#[inline(always)]
fn normalised<V: Pixels>(mean: V) -> V {
    let known = mean.fourths();
    let weight = (mean.splat(GAIN) * known).min(mean.splat(1.0));
    (mean * (weight * known.max(mean.splat(SMALLEST)).recip())).with_fourths(weight)
}

/// Ring buffer of the last four rows, each of which is read twice.
struct Ring<K: KnownRows> {
    /// Row y has index y mod 4.
    rows: [Vec<PremulRgba>; 4],
    held: [Option<usize>; 4],
    blended: Vec<PremulRgba>,
    memory: K::Memory,
}

impl<K: KnownRows> Default for Ring<K> {
    fn default() -> Self {
        Self { rows: Default::default(), held: [None; 4], blended: Vec::new(), memory: K::Memory::default() }
    }
}

impl<K: KnownRows> Ring<K> {
    fn hold(&mut self, known: &K, y: usize) {
        if self.held[y % 4] != Some(y) {
            known.make(y, &mut self.memory, &mut self.rows[y % 4]);
            self.held[y % 4] = Some(y);
        }
    }
}

/// Rows, of `height`, from which row `y` of half the resolution is made.
fn around(y: usize, height: usize) -> [usize; 4] {
    [(2 * y).saturating_sub(1), 2 * y, 2 * y + 1, (2 * y + 2).min(height - 1)]
}

/// Operation that pulls four rows to one.
struct PullRow<'a> {
    rows: [&'a [PremulRgba]; 4],
    blended: &'a mut Vec<PremulRgba>,
    to: &'a mut [PremulRgba],
}

impl SimdF32Op for PullRow<'_> {
    type Output = ();

    #[inline(always)]
    fn run<V: SimdF32>(self, some: V) {
        let Self { rows, blended, to } = self;
        let width = rows[0].len();
        // One more pixel on both sides.
        blended.resize(width + 2, [0.0; 4]);
        // Flat slices of one length, so that the compiler vectorises the loop.
        let [a, b, c, d] = rows.map(|row| row[..width].as_flattened());
        let numbers = blended[1..=width].as_flattened_mut().iter_mut();
        for (to, ((a, b), (c, d))) in numbers.zip(a.iter().zip(b).zip(c.iter().zip(d))) {
            *to = (BINOMIAL[0] * a + BINOMIAL[1] * b) + (BINOMIAL[2] * c + BINOMIAL[3] * d);
        }
        (blended[0], blended[width + 1]) = (blended[1], blended[width]);
        let (from, to) = (blended.as_flattened(), to.as_flattened_mut());
        let whole = to.len() / V::N;
        for vector in 0..whole {
            halved(&from[2 * vector * V::N..], some).store(&mut to[vector * V::N..]);
        }
        for pixel in whole * (V::N / 4)..to.len() / 4 {
            halved(&from[8 * pixel..], Vec4::ZERO).store(&mut to[4 * pixel..]);
        }
    }
}

/// Computes a vector of pixels of half the resolution. `from` begins one pixel before their sources.
#[inline(always)]
fn halved<V: Pixels>(from: &[f32], some: V) -> V {
    let from = &from[..2 * V::N + 8];
    let (first, second) = (some.load(from), some.load(&from[V::N..]));
    let (third, fourth) = (some.load(&from[8..]), some.load(&from[V::N + 8..]));
    let outer = first.evens(second) * some.splat(BINOMIAL[0]) + first.odds(second) * some.splat(BINOMIAL[1]);
    let inner = third.evens(fourth) * some.splat(BINOMIAL[2]) + third.odds(fourth) * some.splat(BINOMIAL[3]);
    normalised(outer + inner)
}

/// Pushes `coarser` into the gaps of `finer`.
fn push(finer: &mut Level, coarser: &Level) {
    let width = finer.width;
    let bands = finer.pixels.par_chunks_mut(BAND * width).with_min_len(SHARED / (BAND * width)).enumerate();
    bands.for_each_init(Vec::new, |blended, (band, rows)| {
        for (y, row) in rows.chunks_exact_mut(width).enumerate() {
            Simd::best().in_vectors(PushRow { y: band * BAND + y, row, coarser, blended });
        }
    });
}

/// Operation that pushes one row.
struct PushRow<'a> {
    y: usize,
    row: &'a mut [PremulRgba],
    coarser: &'a Level,
    blended: &'a mut Vec<PremulRgba>,
}

impl SimdF32Op for PushRow<'_> {
    type Output = ();

    #[inline(always)]
    fn run<V: SimdF32>(self, some: V) {
        let Self { y, row, coarser, blended } = self;
        let [(a, wa), (b, wb)] = halves(y, coarser.height());
        let width = coarser.width;
        // One more pixel on both sides, so that every pixel has two neighbours.
        blended.resize(width + 2, [0.0; 4]);
        let rows = coarser.row(a).as_flattened().iter().zip(coarser.row(b).as_flattened());
        for (to, (a, b)) in blended[1..].as_flattened_mut().iter_mut().zip(rows) {
            *to = wa * a + wb * b;
        }
        double(blended, row, Adding, some);
    }
}

/// Destination of pixels at twice the resolution.
pub trait Put: Copy {
    /// Stores or adds `pixels` at `to`.
    fn put<V: Pixels>(self, pixels: V, to: &mut [f32]);
}

/// Adds pixels to weighted pixels, by the weight that is missing to 1.
#[derive(Debug, Clone, Copy)]
struct Adding;

impl Put for Adding {
    #[inline(always)]
    fn put<V: Pixels>(self, pixels: V, to: &mut [f32]) {
        let known = pixels.load(to);
        (known + (pixels.splat(1.0) - known.fourths()) * pixels).store(to);
    }
}

/// Doubles the resolution of `row` along it and passes the result to `put`: bilinear between pixel centres,
/// replicated at the border. `row` has one more pixel on both sides, which is set here.
#[inline(always)]
pub fn double<V: SimdF32>(row: &mut [PremulRgba], to: &mut [PremulRgba], put: impl Put, some: V) {
    let width = row.len() - 2;
    (row[0], row[width + 1]) = (row[1], row[width]);
    let (from, to) = (row.as_flattened(), to.as_flattened_mut());
    let whole = 4 * width / V::N;
    for vector in 0..whole {
        double_vector(&from[vector * V::N..], &mut to[2 * vector * V::N..], put, some);
    }
    for pixel in whole * (V::N / 4)..width {
        double_vector(&from[4 * pixel..], &mut to[8 * pixel..], put, Vec4::ZERO);
    }
}

/// Doubles one vector of the pixels after the first one of `from`.
#[inline(always)]
fn double_vector<V: Pixels>(from: &[f32], to: &mut [f32], put: impl Put, some: V) {
    let from = &from[..V::N + 8];
    let (left, near, right) = (some.load(from), some.load(&from[4..]), some.load(&from[8..]));
    let near = near * some.splat(0.75);
    let (left, right) = (left * some.splat(0.25), right * some.splat(0.25));
    let (low, high) = to[..2 * V::N].split_at_mut(V::N);
    put.put(near.zip_low(near) + left.zip_low(right), low);
    put.put(near.zip_high(near) + left.zip_high(right), high);
}
