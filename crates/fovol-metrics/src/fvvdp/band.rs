//! One band of the pyramid: local contrasts and their visible differences.

use super::masking::{MASKING, log_difference, power};
use super::pooling::{OVER_PIXELS, TRANSIENT};
use super::sensitivity::{FovealSensitivity, SensitivityTable};
use super::visual_field::VisualField;
use crate::vdp::log_math::log2;
use crate::vdp::pyramid::{Pyramid, expand_row};
use fovol_core::stop;
use rayon::prelude::*;

/// Lower bound of the luminance that contrasts are relative to, in cd/m².
const DARKEST: f32 = 0.1;

/// Largest contrast.
const MOST: f32 = 1000.0;

/// Position of a band's pixels in the visual field.
pub(crate) enum View<'a> {
    /// All pixels in the fovea.
    Foveal(FovealSensitivity),
    /// Pixels around a gaze direction. `log_rho` is the log₂ of the band's frequency in the middle of the display.
    Around { field: &'a VisualField, gaze: [f32; 2], log_rho: f32 },
}

/// One band of reference and test.
pub(crate) struct Band<'a> {
    /// Reference and test of the sustained channel, followed by those of the transient channel if it exists.
    pub pyramids: &'a [Pyramid],
    /// Level of the pyramid.
    pub level: usize,
    /// Factor of contrasts.
    pub gain: f32,
    pub view: View<'a>,
}

/// Difference of one band.
pub(crate) struct BandDifference {
    /// Sums over the pixels of the powers of differences, per channel.
    pub sums: [f64; 2],
    /// Differences per pixel, weighted over the channels; empty if not requested.
    pub map: Vec<f32>,
}

impl Band<'_> {
    /// Measures all pixels. If `mapped`, also returns every pixel's difference.
    pub fn difference(&self, mapped: bool) -> BandDifference {
        let fine = self.pyramids[0].level(self.level);
        let rows: Vec<([f64; 2], Vec<f32>)> = (0..fine.height)
            .into_par_iter()
            .map_init(
                || Scratch::new(fine.width, self.pyramids.len()),
                |scratch, y| {
                    stop::point();
                    self.contrasts(y, scratch);
                    self.sensitivities(y, scratch);
                    self.row_difference(scratch, mapped)
                },
            )
            .collect();
        // Row sums are added in order, so that the result does not depend on the number of threads.
        let sums = [0, 1].map(|c| rows.iter().map(|(sums, _)| sums[c]).sum());
        BandDifference { sums, map: rows.into_iter().flat_map(|(_, map)| map).collect() }
    }

    /// Computes the contrasts of row `y` relative to the reference's local luminance, and that luminance.
    fn contrasts(&self, y: usize, scratch: &mut Scratch) {
        let Scratch { line, contrasts, log_light, scale, .. } = scratch;
        for (pyramid, out) in self.pyramids.iter().zip(contrasts.iter_mut()) {
            expand_row(pyramid.level(self.level + 1), y, line, out);
        }
        let n = contrasts[0].len();
        let (log_light, scale) = (&mut log_light[..n], &mut scale[..n]);
        for (x, surround) in contrasts[0].iter().enumerate() {
            let light = surround.max(DARKEST);
            log_light[x] = log2(light);
            scale[x] = 1.0 / light;
        }
        for (pyramid, contrast) in self.pyramids.iter().zip(contrasts.iter_mut()) {
            let fine = &pyramid.level(self.level).row(y)[..n];
            let contrast = &mut contrast[..n];
            for x in 0..n {
                contrast[x] = ((fine[x] - contrast[x]) * scale[x]).min(MOST) * self.gain;
            }
        }
    }

    /// Computes the log₂ sensitivity of each pixel of row `y` from its luminance.
    fn sensitivities(&self, y: usize, scratch: &mut Scratch) {
        let [steady, change] = &mut scratch.sensitivity;
        let light = &scratch.log_light;
        match &self.view {
            View::Foveal(table) => {
                for x in 0..light.len() {
                    [steady[x], change[x]] = table.log_sensitivity(light[x]);
                }
            }
            View::Around { field, gaze, log_rho } => {
                let roots = &mut scratch.scale;
                field.root_eccentricity(y, *gaze, roots);
                let magnified = field.log_magnification.row(y);
                let table = SensitivityTable::shared();
                for x in 0..light.len() {
                    let rho = log_rho + magnified[x];
                    [steady[x], change[x]] = table.log_sensitivity(rho, light[x], roots[x]);
                }
            }
        }
    }

    /// Sums the powers of a row's differences, and returns the differences if `mapped`.
    fn row_difference(&self, scratch: &mut Scratch, mapped: bool) -> ([f64; 2], Vec<f32>) {
        let Scratch { contrasts, sensitivity, log_difference, powers, .. } = scratch;
        let (mut sums, mut map) = ([0.0; 2], Vec::new());
        for (channel, pair) in contrasts.chunks_exact(2).enumerate() {
            differences(&pair[0], &pair[1], &sensitivity[channel], MASKING[channel], log_difference);
            for (out, &log) in powers.iter_mut().zip(log_difference.iter()) {
                *out = power(log, OVER_PIXELS as f32);
            }
            sums[channel] = powers.iter().map(|&v| f64::from(v)).sum();
            if mapped {
                let weight = if channel == 0 { 1.0 } else { TRANSIENT as f32 };
                map.resize(powers.len(), 0.0);
                for (out, &log) in map.iter_mut().zip(log_difference.iter()) {
                    *out += weight * power(log, 1.0);
                }
            }
        }
        (sums, map)
    }
}

fn differences(reference: &[f32], test: &[f32], sensitivity: &[f32], masking: f32, out: &mut [f32]) {
    let n = out.len();
    let (reference, test, sensitivity) = (&reference[..n], &test[..n], &sensitivity[..n]);
    for x in 0..n {
        out[x] = log_difference(reference[x], test[x], sensitivity[x], masking);
    }
}

/// Intermediate values of one row.
struct Scratch {
    line: Vec<f32>,
    contrasts: Vec<Vec<f32>>,
    log_light: Vec<f32>,
    /// One over luminance; later reused for the square root of eccentricity.
    scale: Vec<f32>,
    sensitivity: [Vec<f32>; 2],
    log_difference: Vec<f32>,
    powers: Vec<f32>,
}

impl Scratch {
    fn new(width: usize, planes: usize) -> Self {
        let row = || vec![0.0; width];
        Self {
            line: Vec::new(),
            contrasts: (0..planes).map(|_| row()).collect(),
            log_light: row(),
            scale: row(),
            sensitivity: [row(), row()],
            log_difference: row(),
            powers: row(),
        }
    }
}
