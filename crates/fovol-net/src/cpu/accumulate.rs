//! Accumulates samples of earlier frames.

use super::doubled::{DoubledRow, doubled};
use super::points::RowMut;
use super::pyramid::{KnownRows, PremulRgba, Pyramid, divided};
use super::samples::KnownPixels;
use super::tensor::Tensor;
use crate::plan::{CONFIDENCE_ALLOWED, CONFIDENCE_EPSILON, CONFIDENCE_SHARE, POINT};
use fovol_simd::{Simd, SimdF32, SimdF32Op, SimdOp};
use glam::Vec4;
use rayon::prelude::*;
use std::array::from_fn;

/// Two pictures with which samples are compared.
#[derive(Debug, Clone, Copy)]
pub struct Expected<'a> {
    /// Last output, reprojected.
    pub prior: &'a Tensor,
    /// Fill of this frame's samples, at half the resolution.
    pub fresh: &'a Tensor,
}

/// Computes the confidence in `prior`, 0…1, at 2^`lowest` times lower resolution than `known`, and writes it to
/// `out`. It compares the mean squared errors of both pictures at the samples; see
/// [`HistoryConfidence`](crate::plan::HistoryConfidence).
pub fn history_confidence(
    known: KnownPixels<'_>,
    expected: &Expected<'_>,
    [levels, lowest]: [u32; 2],
    pyramid: &mut Pyramid,
    out: &mut Tensor,
) {
    match known {
        KnownPixels::All(known) => pyramid.pull_of(&Squares { known, expected }),
        KnownPixels::Samples(samples) => pyramid.pull_samples(samples, |y, sample| {
            let (found, x) = (sample.known().to_array(), sample.x as usize);
            let [r, g, b, _] = doubled(expected.fresh, [y, x]).to_array();
            let prior = expected.prior.row(y).as_chunks().0[x];
            Vec4::new(mean_square(&found, &prior), mean_square(&found, &[r, g, b]), 0.0, 1.0)
        }),
    }
    let [height, width] = known.size().map(|side| side >> lowest);
    out.resize([height, width, 1]);
    pyramid.complete([levels, lowest], &mut out.data, |_, squares, row| {
        for (to, &squares) in row.iter_mut().zip(squares) {
            let [e, v, ..] = divided(Vec4::from_array(squares)).to_array();
            let v = v + CONFIDENCE_EPSILON;
            *to = v / (v + CONFIDENCE_SHARE * (e - CONFIDENCE_ALLOWED * v).max(0.0));
        }
    });
}

/// Mean squared errors of both pictures at the samples.
struct Squares<'a> {
    known: &'a Tensor,
    expected: &'a Expected<'a>,
}

impl KnownRows for Squares<'_> {
    type Memory = DoubledRow;

    fn size(&self) -> [usize; 2] {
        [self.known.height, self.known.width]
    }

    fn make(&self, y: usize, memory: &mut DoubledRow, to: &mut Vec<PremulRgba>) {
        to.resize(self.known.width, [0.0; 4]);
        let known = self.known.row(y).as_chunks().0;
        Simd::best().in_vectors(SquareRow { known, expected: self.expected, y, memory, to });
    }
}

struct SquareRow<'a> {
    known: &'a [PremulRgba],
    expected: &'a Expected<'a>,
    y: usize,
    memory: &'a mut DoubledRow,
    to: &'a mut [PremulRgba],
}

impl SimdF32Op for SquareRow<'_> {
    type Output = ();

    #[inline(always)]
    fn run<V: SimdF32>(self, some: V) {
        let Self { known, expected, y, memory, to } = self;
        memory.make(expected.fresh, y, some);
        let expected = expected.prior.row(y).as_chunks().0.iter().zip(&memory.row);
        for ((to, known), (prior, &[r, g, b, _])) in to.iter_mut().zip(known).zip(expected) {
            *to = [mean_square(known, prior), mean_square(known, &[r, g, b]), 0.0, known[3]];
        }
    }
}

#[inline(always)]
fn mean_square([r, g, b, w]: &PremulRgba, expected: &[f32; 3]) -> f32 {
    let d = [r - w * expected[0], g - w * expected[1], b - w * expected[2]];
    (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]) * (1.0 / 3.0)
}

/// Parameters of accumulation: earlier samples are multiplied by `fade`, by `share` and by the weight that `known`
/// leaves open. `share` has a lower resolution and is interpolated. If earlier samples are points, new ones become
/// points at pixel centres.
#[derive(Debug, Clone, Copy)]
pub struct Fading<'a> {
    pub known: KnownPixels<'a>,
    pub share: Option<&'a Tensor>,
    pub fade: f32,
}

impl Fading<'_> {
    /// Accumulates row `y` in place: `numbers` holds earlier samples, `channels` per pixel. `shares` is scratch
    /// memory.
    #[inline(always)]
    pub fn row(&self, y: usize, channels: usize, numbers: &mut [f32], shares: &mut Vec<f32>) {
        shares.resize(numbers.len() / channels, 0.0);
        match self.share {
            None => shares.fill(1.0),
            Some(share) => scaled_row(share, self.known.size()[0] / share.height, y, shares),
        }
        match channels {
            POINT => self.points(y, shares, RowMut::of(numbers)),
            _ => self.pixels(y, shares, numbers.as_chunks_mut().0),
        }
    }

    fn pixels(&self, y: usize, shares: &[f32], row: &mut [PremulRgba]) {
        let fade = self.fade;
        match self.known {
            KnownPixels::All(known) => {
                let known = known.row(y).as_chunks().0;
                Simd::best().vectorised(AccumulateRow { known, shares, fade, row });
            }
            KnownPixels::Samples(samples) => {
                Simd::best().vectorised(FadeRow { shares, fade, row: &mut *row });
                samples.row(y).iter().for_each(|sample| row[sample.x as usize] = sample.known().to_array());
            }
        }
    }

    fn points(&self, y: usize, shares: &[f32], mut row: RowMut<'_>) {
        let fade = self.fade;
        match self.known {
            KnownPixels::All(known) => {
                let known = known.row(y).as_chunks().0;
                Simd::best().vectorised(AccumulatePoints { known, shares, fade, row });
            }
            KnownPixels::Samples(samples) => {
                Simd::best().vectorised(FadePoints { shares, fade, row: &mut row });
                for sample in samples.row(y) {
                    let [r, g, b, w] = sample.known().to_array();
                    row.set(sample.x as usize, [r, g, b, w, 0.0, 0.0]);
                }
            }
        }
    }
}

/// Accumulates in place: `map` holds earlier samples.
pub fn accumulate(fading: Fading<'_>, map: &mut Tensor) {
    let Tensor { width, channels, .. } = *map;
    let rows = map.data.par_chunks_mut(channels * width).enumerate();
    rows.for_each_init(Vec::new, |shares, (y, row)| fading.row(y, channels, row, shares));
}

/// Operation that fades a row without new samples.
struct FadeRow<'a> {
    shares: &'a [f32],
    fade: f32,
    row: &'a mut [PremulRgba],
}

impl SimdOp for FadeRow<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for (known, share) in self.row.iter_mut().zip(self.shares) {
            *known = (Vec4::from_array(*known) * (self.fade * share)).to_array();
        }
    }
}

/// Operation that fades a row of points without new samples. Points keep their offsets.
struct FadePoints<'a, 'b> {
    shares: &'a [f32],
    fade: f32,
    row: &'a mut RowMut<'b>,
}

impl SimdOp for FadePoints<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { shares, fade, row } = self;
        for n in 0..4 {
            for (number, share) in row.numbers(n).iter_mut().zip(shares) {
                *number *= fade * share;
            }
        }
    }
}

/// Interpolates row `y` of `map` (one channel) at `scale` times its resolution: bilinear between pixel centres,
/// replicated at the border.
fn scaled_row(map: &Tensor, scale: usize, y: usize, to: &mut [f32]) {
    let simd = Simd::best();
    match scale {
        1 => simd.vectorised(ScaledRow::<1> { map, y, to }),
        2 => simd.vectorised(ScaledRow::<2> { map, y, to }),
        4 => simd.vectorised(ScaledRow::<4> { map, y, to }),
        8 => simd.vectorised(ScaledRow::<8> { map, y, to }),
        _ => unreachable!("confidence has at most 8 times lower resolution"),
    }
}

/// Operation that computes such a row.
struct ScaledRow<'a, const SCALE: usize> {
    map: &'a Tensor,
    y: usize,
    to: &'a mut [f32],
}

impl<const SCALE: usize> SimdOp for ScaledRow<'_, SCALE> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { map, y, to } = self;
        let scale = SCALE as f32;
        let places: [f32; SCALE] = from_fn(|i| (i as f32 + 0.5) / scale - 0.5);
        let down = ((y as f32 + 0.5) / scale - 0.5).max(0.0);
        let above = down as usize;
        let (a, b) = (map.row(above), map.row((above + 1).min(map.height - 1)));
        let t = down - above as f32;
        let last = map.width - 1;
        let [mut here, mut right] = [0, 1.min(last)].map(|x| a[x] + t * (b[x] - a[x]));
        let mut left = here;
        for (x, cell) in to.as_chunks_mut::<SCALE>().0.iter_mut().enumerate() {
            let (before, after) = cell.split_at_mut(SCALE / 2);
            for (to, place) in before.iter_mut().zip(&places) {
                *to = here + place * (here - left);
            }
            for (to, place) in after.iter_mut().zip(&places[SCALE / 2..]) {
                *to = here + place * (right - here);
            }
            let next = (x + 2).min(last);
            (left, here, right) = (here, right, a[next] + t * (b[next] - a[next]));
        }
    }
}

struct AccumulateRow<'a> {
    known: &'a [PremulRgba],
    shares: &'a [f32],
    fade: f32,
    row: &'a mut [PremulRgba],
}

impl SimdOp for AccumulateRow<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for (to, (known, share)) in self.row.iter_mut().zip(self.known.iter().zip(self.shares)) {
            let factor = (1.0 - known[3]) * (self.fade * share);
            let before = *to;
            *to = from_fn(|c| known[c] + factor * before[c]);
        }
    }
}

/// Operation that accumulates a row of points.
struct AccumulatePoints<'a> {
    known: &'a [PremulRgba],
    shares: &'a [f32],
    fade: f32,
    row: RowMut<'a>,
}

impl SimdOp for AccumulatePoints<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { known, shares, fade, mut row } = self;
        for n in 0..POINT {
            for (to, (known, share)) in row.numbers(n).iter_mut().zip(known.iter().zip(shares)) {
                let open = 1.0 - known[3];
                *to = if n < 4 { known[n] + open * (fade * share) * *to } else { open * *to };
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Samples at every other pixel of 32², with values 0.2 and 0.4 in turn.
    fn samples() -> Tensor {
        let mut known = Tensor::zeros(32, 32, 4);
        for i in (0..32 * 32).filter(|i| (i + i / 32) % 2 == 0) {
            let v = if i % 4 < 2 { 0.2 } else { 0.4 };
            known.data[4 * i..][..4].copy_from_slice(&[v, v, v, 1.0]);
        }
        known
    }

    #[test]
    fn what_samples_contradict_is_not_believed() {
        let picture = |side: usize, value: f32| {
            let data = vec![value; side * side * 3].into();
            Tensor { data, height: side, width: side, channels: 3 }
        };
        let share = |prior: f32| {
            let (prior, fresh) = (picture(32, prior), picture(16, 0.3));
            let mut out = Tensor::default();
            let expected = Expected { prior: &prior, fresh: &fresh };
            history_confidence(
                KnownPixels::All(&samples()),
                &expected,
                [4, 3],
                &mut Pyramid::default(),
                &mut out,
            );
            assert_eq!([out.height, out.width], [4, 4]);
            assert!(out.data.iter().all(|v| (v - out.data[0]).abs() < 0.06), "{:?}", out.data);
            out.data[0]
        };
        // Samples differ by 0.1 from both pictures.
        let alike = 0.01 / (0.01 + CONFIDENCE_SHARE * (0.01 - CONFIDENCE_ALLOWED * 0.01));
        assert!((share(0.3) - alike).abs() < 1e-3);
        // Samples differ by 0.1 and 0.3 from `prior`, and by 0.1 from the fill.
        let expected = 0.01 / (0.01 + CONFIDENCE_SHARE * (0.05 - CONFIDENCE_ALLOWED * 0.01));
        assert!((share(0.5) - expected).abs() < 0.03 && share(9.0) < 0.001);
    }

    #[test]
    fn earlier_samples_fade_where_there_are_no_new_ones() {
        let samples = samples();
        let ones = || Tensor { data: vec![1.0; 32 * 32 * 4].into(), height: 32, width: 32, channels: 4 };
        let share = Tensor { data: vec![0.5; 16].into(), height: 4, width: 4, channels: 1 };
        let mut out = ones();
        let known = KnownPixels::All(&samples);
        accumulate(Fading { known, share: Some(&share), fade: 0.8 }, &mut out);
        assert_eq!(out.pixel(0, 0), samples.pixel(0, 0));
        assert_eq!(out.pixel(0, 1), [0.4; 4]);
        let mut out = ones();
        accumulate(Fading { known, share: None, fade: 0.8 }, &mut out);
        assert_eq!(out.pixel(0, 1), [0.8; 4]);
    }
}
