//! One band of the pyramid: contrasts relative to the threshold of the eye, and their visible differences.

use super::blur::Blur;
use super::masking::{CONTRAST, Masking};
use super::pooling::pixel;
use super::sensitivity::Sensitivity;
use crate::vdp::log_math::{exp2, log2};
use crate::vdp::pyramid::{Pyramid, expand_row};
use fovol_core::stop;
use rayon::prelude::*;

/// Lower bound of the luminance that contrasts are relative to, in cd/m².
pub(crate) const DARKEST: f32 = 0.01;

/// Largest contrast.
pub(crate) const MOST: f32 = 1000.0;

/// One band of reference and test.
pub(crate) struct Band<'a> {
    /// Channels of the reference and of the test.
    pub pyramids: &'a [Vec<Pyramid>; 2],
    /// Level of the pyramid.
    pub level: usize,
    /// Sensitivity at the band's frequency.
    pub sensitivity: &'a Sensitivity,
    pub blur: &'a Blur,
    pub masking: &'a Masking,
}

impl Band<'_> {
    /// Sums of the pixels' differences, per channel. `store` is scratch memory of at least [`Self::stored`] values.
    pub fn sums(&self, store: &mut [f32]) -> [f64; 4] {
        let (width, height) = self.size();
        let channels = self.channels();
        let store = &mut store[..self.stored()];
        store.par_chunks_mut(2 * channels * width).enumerate().for_each_init(
            || Contrasts::new(width, channels),
            |scratch, (y, record)| {
                stop::point();
                self.contrasts(y, scratch);
                self.compare(scratch, record);
            },
        );
        let store = &*store;
        let rows: Vec<[f64; 4]> = (0..height)
            .into_par_iter()
            .map_init(
                || Differences::new(width, channels),
                |scratch, y| {
                    stop::point();
                    self.row_sums(y, store, scratch)
                },
            )
            .collect();
        // Row sums are added in order, so that the result does not depend on the number of threads.
        [0, 1, 2, 3].map(|channel| rows.iter().map(|sums| sums[channel]).sum())
    }

    /// Values that [`Self::sums`] stores: for every row and channel, differences and shared contrasts.
    pub fn stored(&self) -> usize {
        let (width, height) = self.size();
        2 * self.channels() * width * height
    }

    fn size(&self) -> (usize, usize) {
        let plane = self.pyramids[0][0].level(self.level);
        (plane.width, plane.height)
    }

    fn channels(&self) -> usize {
        self.pyramids[0].len()
    }

    /// Computes the contrasts of row `y`, each picture's relative to its own local luminance, and log₂ sensitivities
    /// for the reference's luminance.
    fn contrasts(&self, y: usize, scratch: &mut Contrasts) {
        // A band-pass keeps about half of a pattern's amplitude; the finest band is a high-pass.
        let gain = if self.level == 0 { 1.0 } else { 2.0 };
        let Contrasts { line, contrasts, scale, sensitivity, .. } = scratch;
        for (side, (pyramids, contrasts)) in self.pyramids.iter().zip(contrasts).enumerate() {
            for (pyramid, out) in pyramids.iter().zip(contrasts.iter_mut()) {
                expand_row(pyramid.level(self.level + 1), y, line, out);
            }
            for (scale, surround) in scale.iter_mut().zip(&contrasts[0]) {
                *scale = surround.max(DARKEST);
            }
            if side == 0 {
                self.sensitivities(scale, sensitivity);
            }
            scale.iter_mut().for_each(|v| *v = 1.0 / *v);
            for (pyramid, contrast) in pyramids.iter().zip(contrasts) {
                let fine = pyramid.level(self.level).row(y);
                for ((contrast, fine), scale) in contrast.iter_mut().zip(fine).zip(scale.iter()) {
                    *contrast = ((fine - *contrast) * scale).min(MOST) * gain;
                }
            }
        }
    }

    /// Computes the sensitivity of each channel at each pixel, with the channel's gain, from the luminance `light`.
    fn sensitivities(&self, light: &[f32], sensitivity: &mut [Vec<f32>]) {
        for (x, light) in light.iter().enumerate() {
            let found = self.sensitivity.at(log2(*light));
            for (channel, out) in sensitivity.iter_mut().enumerate() {
                out[x] = found[channel];
            }
        }
        for (out, gain) in sensitivity.iter_mut().zip(CONTRAST) {
            out.iter_mut().for_each(|v| *v = gain * exp2(*v));
        }
    }

    /// Fills a row's record: the absolute difference of each channel, and then the contrast that both pictures share,
    /// blurred along the row.
    fn compare(&self, scratch: &mut Contrasts, record: &mut [f32]) {
        let Contrasts { line, contrasts: [reference, test], sensitivity, scale: shared, .. } = scratch;
        let (width, height) = self.size();
        let blurs = Blur::reaches(width, height);
        let (differences, masks) = record.split_at_mut(record.len() / 2);
        let rows = differences.chunks_exact_mut(width).zip(masks.chunks_exact_mut(width));
        for (channel, (difference, mask)) in rows.enumerate() {
            let (r, t, s) =
                (&reference[channel][..width], &test[channel][..width], &sensitivity[channel][..width]);
            let shared = &mut shared[..width];
            for x in 0..width {
                difference[x] = (t[x] * s[x] - r[x] * s[x]).abs();
                shared[x] = (t[x] * s[x]).abs().min((r[x] * s[x]).abs());
            }
            if blurs {
                self.blur.along_row(shared, line, mask);
            } else {
                mask.copy_from_slice(shared);
            }
        }
    }

    /// Sums the visible differences of row `y`.
    fn row_sums(&self, y: usize, store: &[f32], scratch: &mut Differences) -> [f64; 4] {
        let Differences { differences, masks, total } = scratch;
        let (width, height) = self.size();
        let channels = self.channels();
        let row = |y: usize, part: usize| &store[(2 * channels * y + part) * width..][..width];
        for (channel, (difference, mask)) in differences.iter_mut().zip(masks.iter_mut()).enumerate() {
            difference.copy_from_slice(row(y, channel));
            if Blur::reaches(width, height) {
                self.blur.across_rows(y, height, |y| row(y, channels + channel), mask);
            } else {
                mask.copy_from_slice(row(y, channels + channel));
            }
        }
        self.masking.apply(differences, masks, total);
        let mut sums = [0.0; 4];
        for (sum, difference) in sums.iter_mut().zip(differences) {
            *sum = difference.iter().map(|&v| f64::from(pixel(v))).sum();
        }
        sums
    }
}

/// Intermediate values of one row's contrasts.
struct Contrasts {
    line: Vec<f32>,
    contrasts: [Vec<Vec<f32>>; 2],
    /// Local luminance, then one over it, then the contrast that both pictures share.
    scale: Vec<f32>,
    sensitivity: Vec<Vec<f32>>,
}

impl Contrasts {
    fn new(width: usize, channels: usize) -> Self {
        let rows = || vec![vec![0.0; width]; channels];
        Self { line: Vec::new(), contrasts: [rows(), rows()], scale: vec![0.0; width], sensitivity: rows() }
    }
}

/// Intermediate values of one row's differences, one row per channel.
struct Differences {
    differences: Vec<Vec<f32>>,
    masks: Vec<Vec<f32>>,
    total: Vec<f32>,
}

impl Differences {
    fn new(width: usize, channels: usize) -> Self {
        let rows = || vec![vec![0.0; width]; channels];
        Self { differences: rows(), masks: rows(), total: vec![0.0; width] }
    }
}
