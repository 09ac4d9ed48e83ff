//! Fills frames from weighted pixels: spread, smooth and blend.

use crate::cpu::fill::doubled::{DoubledRow, doubled};
use crate::cpu::fill::pyramid::{KnownRows, Pyramid, divided};
use crate::cpu::tensor::Tensor;
use crate::cpu::tensor::samples::PremulRgba;
use crate::cpu::tensor::samples::{self, KnownPixels};
use fovol_simd::{Pixels, Simd, SimdF32, SimdF32Op, SimdOp};
use glam::Vec4;
use rayon::prelude::*;

/// Fills `known` at half the resolution by pull-push, with `levels` halvings, and writes the picture to `out`. With
/// `base` it fills the residuals of `base` at `known`, and adds `base`.
pub fn spread(
    known: KnownPixels<'_>,
    base: Option<&Tensor>,
    levels: u32,
    pyramid: &mut Pyramid,
    out: &mut Tensor,
) {
    match (known, base) {
        (KnownPixels::All(known), None) => pyramid.pull_from(samples::pixels(known), known.width),
        (KnownPixels::All(known), Some(base)) => pyramid.pull_of(&Differences { known, base }),
        (KnownPixels::Samples(samples), None) => pyramid.pull_samples(samples, |_, sample| sample.known()),
        (KnownPixels::Samples(samples), Some(base)) => {
            pyramid.pull_samples(samples, |y, sample| sample.known() - doubled(base, [y, sample.x as usize]));
        }
    }
    let [height, width] = known.size().map(|side| side / 2);
    out.resize([height, width, 3]);
    pyramid.complete([levels, 1], &mut out.data, |y, known, row| {
        Simd::best().in_vectors(SpreadRow { known, base: base.map(|base| base.row(y)), row });
    });
}

struct SpreadRow<'a> {
    known: &'a [PremulRgba],
    base: Option<&'a [f32]>,
    row: &'a mut [f32],
}

impl SimdF32Op for SpreadRow<'_> {
    type Output = ();

    #[inline(always)]
    fn run<V: SimdF32>(self, some: V) {
        let Self { known, base, row } = self;
        let whole = whole_vectors::<V>(row.len() / 3);
        for vector in 0..whole {
            let (from, to) = (vector * V::N, vector * V::N / 4 * 3);
            let known = some.load(&known.as_flattened()[from..]);
            let pixels = divided(known).without_fourths();
            let pixels = if let Some(base) = base { pixels + some.load(&base[to..]) } else { pixels };
            pixels.store(&mut row[to..]);
        }
        for (x, &known) in known.iter().enumerate().skip(whole * V::N / 4) {
            for (c, number) in divided(Vec4::from_array(known)).to_array().into_iter().take(3).enumerate() {
                row[3 * x + c] = base.map_or(0.0, |base| base[3 * x + c]) + number;
            }
        }
    }
}

/// Residuals: weighted pixels minus a picture of half their resolution.
struct Differences<'a> {
    known: &'a Tensor,
    base: &'a Tensor,
}

impl KnownRows for Differences<'_> {
    type Memory = DoubledRow;

    fn size(&self) -> [usize; 2] {
        [self.known.height, self.known.width]
    }

    fn make(&self, y: usize, memory: &mut DoubledRow, to: &mut Vec<PremulRgba>) {
        to.resize(self.known.width, [0.0; 4]);
        Simd::best().in_vectors(DifferenceRow { known: self.known.row(y), base: self.base, y, memory, to });
    }
}

/// Operation that computes the residuals of one row.
struct DifferenceRow<'a> {
    known: &'a [f32],
    base: &'a Tensor,
    y: usize,
    memory: &'a mut DoubledRow,
    to: &'a mut [PremulRgba],
}

impl SimdF32Op for DifferenceRow<'_> {
    type Output = ();

    #[inline(always)]
    fn run<V: SimdF32>(self, some: V) {
        let Self { known, base, y, memory, to } = self;
        memory.make(base, y, some);
        let (base, to) = (memory.row.as_flattened(), to.as_flattened_mut());
        let whole = to.len() / V::N * V::N;
        let vectors = known.chunks_exact(V::N).zip(base.chunks_exact(V::N));
        for (to, (known, base)) in to.chunks_exact_mut(V::N).zip(vectors) {
            difference(some.load(known), some.load(base)).store(to);
        }
        let rest = known[whole..].chunks_exact(4).zip(base[whole..].chunks_exact(4));
        for (to, (known, base)) in to[whole..].chunks_exact_mut(4).zip(rest) {
            difference(Vec4::from_slice(known), Vec4::from_slice(base)).write_to_slice(to);
        }
    }
}

/// Computes the residual of `base` at weighted pixels. The fourth channel of `base` is 0, so the weight is
/// unchanged.
#[inline(always)]
fn difference<V: Pixels>(known: V, base: V) -> V {
    known - known.fourths() * base
}

/// Writes `known` to `out`, and adds `base`, a picture of half the resolution, by the weight that is missing to 1.
pub fn blend(known: KnownPixels<'_>, base: &Tensor, out: &mut Tensor) {
    let [height, width] = known.size();
    out.resize([height, width, 3]);
    let rows = out.data.par_chunks_mut(width * 3).enumerate();
    rows.for_each_init(DoubledRow::default, |memory, (y, to)| {
        let to = to.as_chunks_mut().0;
        match known {
            KnownPixels::All(known) => {
                let known = known.row(y).as_chunks().0;
                Simd::best().in_vectors(BlendRow { known, base, y, memory, to });
            }
            KnownPixels::Samples(samples) => {
                Simd::best().in_vectors(BaseRow { base, y, memory, to: &mut *to });
                samples.row(y).iter().for_each(|sample| to[sample.x as usize] = sample.colour);
            }
        }
    });
}

/// Operation that writes a row of `base` alone.
struct BaseRow<'a> {
    base: &'a Tensor,
    y: usize,
    memory: &'a mut DoubledRow,
    to: &'a mut [[f32; 3]],
}

impl SimdF32Op for BaseRow<'_> {
    type Output = ();

    #[inline(always)]
    fn run<V: SimdF32>(self, some: V) {
        self.memory.make(self.base, self.y, some);
        let (from, whole) = (&self.memory.row[..], whole_vectors::<V>(self.to.len()));
        for vector in 0..whole {
            let at = vector * V::N / 4;
            let pixels = some.load(&from.as_flattened()[4 * at..]);
            pixels.without_fourths().store(&mut self.to.as_flattened_mut()[3 * at..]);
        }
        for (to, &[r, g, b, _]) in self.to.iter_mut().zip(from).skip(whole * V::N / 4) {
            *to = [r, g, b];
        }
    }
}

struct BlendRow<'a> {
    known: &'a [PremulRgba],
    base: &'a Tensor,
    y: usize,
    memory: &'a mut DoubledRow,
    to: &'a mut [[f32; 3]],
}

impl SimdF32Op for BlendRow<'_> {
    type Output = ();

    #[inline(always)]
    fn run<V: SimdF32>(self, some: V) {
        let Self { known, base, y, memory, to } = self;
        memory.make(base, y, some);
        let (from, whole) = (&memory.row[..], whole_vectors::<V>(to.len()));
        for vector in 0..whole {
            let at = vector * V::N / 4;
            let known = some.load(&known.as_flattened()[4 * at..]);
            let base = some.load(&from.as_flattened()[4 * at..]);
            let pixels = known + (some.splat(1.0) - known.fourths()) * base;
            pixels.without_fourths().store(&mut to.as_flattened_mut()[3 * at..]);
        }
        for (x, to) in to.iter_mut().enumerate().skip(whole * V::N / 4) {
            let ([known @ .., weight], base) = (&known[x], &from[x]);
            *to = [0, 1, 2].map(|c| known[c] + (1.0 - weight) * base[c]);
        }
    }
}

/// Number of vectors that can be stored one after the other in `pixels` pixels of three values. Each vector writes
/// beyond its own pixels; the next one overwrites the excess.
#[inline(always)]
fn whole_vectors<V: SimdF32>(pixels: usize) -> usize {
    (3 * pixels).checked_sub(V::N).map_or(0, |room| room / (V::N / 4 * 3) + 1)
}

/// Smooths `input` by (1, 2, 1)/4 along both axes, replicated at the border, and writes to `out`.
pub fn smooth(input: &Tensor, out: &mut Tensor) {
    let [height, width, c] = [input.height, input.width, input.channels];
    out.resize([height, width, c]);
    out.data.par_chunks_mut(width * c).enumerate().for_each_init(Vec::new, |between, (y, to)| {
        let rows = [y.saturating_sub(1), y, (y + 1).min(height - 1)].map(|y| input.row(y));
        Simd::best().vectorised(SmoothRow { rows, channels: c, between, to });
    });
}

struct SmoothRow<'a> {
    rows: [&'a [f32]; 3],
    channels: usize,
    between: &'a mut Vec<f32>,
    to: &'a mut [f32],
}

impl SimdOp for SmoothRow<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { rows: [above, row, below], channels: c, between, to } = self;
        let length = row.len();
        between.resize(length + 2 * c, 0.0);
        for (to, (a, (b, d))) in
            between[c..length + c].iter_mut().zip(above.iter().zip(row.iter().zip(below)))
        {
            *to = 0.25 * (a + d) + 0.5 * b;
        }
        between.copy_within(c..2 * c, 0);
        between.copy_within(length..length + c, length + c);
        let (left, right) = (&between[..length], &between[2 * c..]);
        for (to, (a, (b, d))) in to.iter_mut().zip(left.iter().zip(between[c..].iter().zip(right))) {
            *to = 0.25 * (a + d) + 0.5 * b;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cpu::tensor::samples::Samples;
    use fovol_core::{Frame, FrameSize, SparseFrame};
    use proptest::prelude::*;

    fn spread(known: &Tensor, base: Option<&Tensor>, levels: u32, out: &mut Tensor) {
        super::spread(KnownPixels::All(known), base, levels, &mut Pyramid::default(), out);
    }

    fn blend(known: &Tensor, base: &Tensor, out: &mut Tensor) {
        super::blend(KnownPixels::All(known), base, out);
    }

    #[test]
    fn samples_stay_and_one_fills_all() {
        let (mut known, mut half, mut out) = (Tensor::zeros(16, 32, 4), Tensor::default(), Tensor::default());
        spread(&known, None, 4, &mut half);
        blend(&known, &half, &mut out);
        assert!(out.data.iter().all(|&v| v == 0.0));
        known.data[4 * (5 * 32 + 7)..][..4].copy_from_slice(&[0.25, 0.5, 1.0, 1.0]);
        spread(&known, None, 4, &mut half);
        blend(&known, &half, &mut out);
        assert_eq!(out.pixel(5, 7), [0.25, 0.5, 1.0]);
        let near = out.pixel(6, 9);
        assert!((near[0] - 0.25).abs() < 1e-5 && (near[2] - 1.0).abs() < 1e-5, "{near:?}");
    }

    #[test]
    fn corrections_bring_slopes_nearer() {
        let slope = |y: usize, x: usize| (3 * x + y) as f32 / 200.0;
        let mut known = Tensor::zeros(32, 64, 4);
        for i in (0..32 * 64).filter(|i| i * 7919 % 23 == 0) {
            let v = slope(i / 64, i % 64);
            known.data[4 * i..][..4].copy_from_slice(&[v, v, v, 1.0]);
        }
        let (mut half, mut smoothed, mut out) = (Tensor::default(), Tensor::default(), Tensor::default());
        spread(&known, None, 4, &mut half);
        let mut errors = Vec::new();
        for _ in 0..3 {
            blend(&known, &half, &mut out);
            let differences = (0..32 * 64).map(|i| (out.data[3 * i] - slope(i / 64, i % 64)).powi(2));
            errors.push(differences.sum::<f32>());
            smooth(&half, &mut smoothed);
            spread(&known, Some(&smoothed), 4, &mut half);
        }
        assert!(errors[1] < 0.7 * errors[0] && errors[2] < errors[1], "{errors:?}");
    }

    proptest! {
        #[test]
        fn samples_alone_give_what_a_frame_of_them_gives(
            [height, width] in prop::array::uniform2(1usize..4),
            picks in prop::collection::vec((any::<prop::sample::Index>(), prop::array::uniform3(0f32..1.0)), 0..40),
        ) {
            let size = FrameSize { width: 16 * width as u32, height: 16 * height as u32 };
            let mut frame = Frame::new(size);
            for (at, [r, g, b]) in picks {
                let at = at.index(size.pixels());
                frame.pixels_mut()[at] = [r, g, b, 1.0];
            }
            let (mut map, mut samples) = (Tensor::zeros(16 * height, 16 * width, 4), Samples::default());
            map.data.copy_from_slice(frame.pixels().as_flattened());
            samples.gather(&SparseFrame::from(&frame), [16 * height, 16 * width]);
            let mut made = Vec::new();
            for known in [KnownPixels::All(&map), KnownPixels::Samples(&samples)] {
                let [mut half, mut smoothed, mut corrected, mut out] = [(); 4].map(|()| Tensor::default());
                let mut pyramid = Pyramid::default();
                super::spread(known, None, 4, &mut pyramid, &mut half);
                smooth(&half, &mut smoothed);
                super::spread(known, Some(&smoothed), 4, &mut pyramid, &mut corrected);
                super::blend(known, &corrected, &mut out);
                made.push(out);
            }
            for (a, b) in made[0].data.iter().zip(&made[1].data) {
                prop_assert!((a - b).abs() < 1e-5, "{a} and {b}");
            }
        }
    }
}
