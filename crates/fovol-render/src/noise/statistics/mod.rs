//! Measures whether ranks are spatio-temporal blue noise, and checks each figure against a limit.
//!
//! Powers are normalised so that white noise has 1 at every frequency.

use super::size::NoiseSize;
use rustfft::FftPlanner;
use rustfft::num_complex::Complex;
use serde::Serialize;

/// One figure and whether it lies within its limit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Check {
    /// The name of the figure.
    pub name: String,
    /// The measured value.
    pub value: f64,
    /// The limit in words, such as `below 0.0010`.
    pub limit: String,
    /// Whether the value lies within the limit.
    pub passed: bool,
}

/// All checks, and the spectra that they were taken from.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Report {
    /// The checks.
    pub checks: Vec<Check>,
    /// Radial spatial power of the frames: [frequency in cycles per pixel, power].
    pub spatial_power: Vec<[f64; 2]>,
    /// Temporal power of the pixels: [frequency in cycles per frame, power].
    pub temporal_power: Vec<[f64; 2]>,
}

/// Densities that masks are checked at.
const DENSITIES: [f64; 4] = [0.01, 0.03, 0.07, 0.1];
/// Rings that spatial frequencies are counted in.
const RINGS: usize = 48;
/// The frames after which coverage is counted.
const COVERAGE_FRAMES: usize = 8;

/// Checks `ranks`, \[t\]\[y\]\[x\] of `size`.
///
/// # Panics
/// When there are not as many ranks as `size` says.
pub fn check(ranks: &[u32], size: NoiseSize) -> Report {
    assert_eq!(ranks.len(), size.len(), "as many ranks as the size says");
    let values: Vec<f64> = ranks.iter().map(|&r| (f64::from(r) + 0.5) / size.len() as f64).collect();
    let Spectra { spatial: spatial_power, temporal: temporal_power } = spectra(&values, size);
    let mut checks = vec![permutation(ranks), frame_means(&values, size)];
    checks.extend(spatial_checks(&spatial_power));
    if size.frames >= 16 {
        checks.extend(temporal_checks(&values, size, &temporal_power));
    }
    for density in DENSITIES {
        checks.extend(mask_checks(&values, size, density));
    }
    Report { checks, spatial_power, temporal_power }
}

/// How much noise there is at which frequency; white noise has a power of 1 everywhere.
#[derive(Debug, Clone, PartialEq)]
pub struct Spectra {
    /// Radial power of the frames: \[frequency in cycles per pixel, power\].
    pub spatial: Vec<[f64; 2]>,
    /// Power of the pixels over time: \[frequency in cycles per frame, power\].
    pub temporal: Vec<[f64; 2]>,
}

/// The spectra of thresholds between 0 and 1, \[t\]\[y\]\[x\] of `size`.
///
/// # Panics
/// When there are not as many thresholds as `size` says.
pub fn spectra(values: &[f64], size: NoiseSize) -> Spectra {
    assert_eq!(values.len(), size.len(), "as many thresholds as the size says");
    Spectra { spatial: radial_power(values, size, 1.0 / 12.0), temporal: temporal_power(values, size) }
}

fn below(name: impl Into<String>, value: f64, limit: f64) -> Check {
    Check { name: name.into(), value, limit: format!("below {limit:.4}"), passed: value < limit }
}

fn above(name: impl Into<String>, value: f64, limit: f64) -> Check {
    Check { name: name.into(), value, limit: format!("above {limit:.4}"), passed: value > limit }
}

fn permutation(ranks: &[u32]) -> Check {
    let mut seen = vec![false; ranks.len()];
    let once = |r: &&u32| seen.get_mut(**r as usize).is_some_and(|s| !std::mem::replace(s, true));
    let different = ranks.iter().filter(once).count();
    above("share of different ranks below their number", different as f64 / ranks.len() as f64, 1.0 - 1e-12)
}

fn frame_means(values: &[f64], size: NoiseSize) -> Check {
    let means: Vec<f64> = values.chunks(size.width * size.height).map(mean).collect();
    below("standard deviation of frame means", deviation(&means), 1e-3)
}

fn spatial_checks(power: &[[f64; 2]]) -> [Check; 2] {
    let between = |from: f64, to: f64| {
        let inside: Vec<f64> = power.iter().filter(|[f, _]| *f >= from && *f < to).map(|[_, p]| *p).collect();
        mean(&inside)
    };
    [
        below("spatial power below 0.12 cycles a pixel", between(0.0, 0.12), 0.02),
        above("spatial power above 0.3 cycles a pixel", between(0.3, 0.5), 1.1),
    ]
}

fn temporal_checks(values: &[f64], size: NoiseSize, power: &[[f64; 2]]) -> [Check; 3] {
    let low: Vec<f64> = power.iter().filter(|[f, _]| *f > 0.0 && *f <= 1.0 / 16.0).map(|[_, p]| *p).collect();
    let high: Vec<f64> = power.iter().filter(|[f, _]| *f >= 0.4).map(|[_, p]| *p).collect();
    let pixels = size.width * size.height;
    let means: Vec<f64> = (0..pixels)
        .map(|p| (0..size.frames).map(|t| values[t * pixels + p]).sum::<f64>() / size.frames as f64)
        .collect();
    let white = (1.0 / 12.0 / size.frames as f64).sqrt();
    [
        below("temporal power up to 1/16 cycles a frame", mean(&low), 0.05),
        above("temporal power from 0.4 cycles a frame", mean(&high), 1.4),
        below("deviation of pixel means, of white noise's", deviation(&means) / white, 0.2),
    ]
}

fn mask_checks(values: &[f64], size: NoiseSize, density: f64) -> Vec<Check> {
    let mask: Vec<f64> = values.iter().map(|&v| f64::from(u8::from(v < density))).collect();
    let frame = size.width * size.height;
    let worst = mask.chunks(frame).map(|m| (mean(m) - density).abs()).fold(0.0, f64::max);
    let limit = 0.5 * density.sqrt();
    let power = radial_power(&mask, size, density * (1.0 - density));
    let low: Vec<f64> = power.iter().filter(|[f, _]| *f < limit).map(|[_, p]| *p).collect();
    let mut checks = vec![
        below(format!("density {density}: worst frame off by"), worst, 0.002),
        below(format!("density {density}: low-frequency power"), mean(&low), 0.3),
    ];
    if size.frames >= COVERAGE_FRAMES {
        let covered = (0..frame).filter(|p| (0..COVERAGE_FRAMES).any(|t| mask[t * frame + p] > 0.0)).count();
        let white = 1.0 - (1.0 - density).powi(COVERAGE_FRAMES as i32);
        checks.push(above(
            format!("density {density}: coverage after 8 frames"),
            covered as f64 / frame as f64,
            white,
        ));
    }
    checks
}

/// The power of the frames by distance from frequency 0, averaged over frames; a value of `variance` and
/// no correlation gives 1.
fn radial_power(values: &[f64], size: NoiseSize, variance: f64) -> Vec<[f64; 2]> {
    let (w, h) = (size.width, size.height);
    let mut planner = FftPlanner::new();
    let (rows, columns) = (planner.plan_fft_forward(w), planner.plan_fft_forward(h));
    let mut sums = vec![(0.0, 0u64); RINGS];
    for frame in values.chunks(w * h) {
        let average = mean(frame);
        let mut plane: Vec<Complex<f64>> = frame.iter().map(|v| Complex::new(v - average, 0.0)).collect();
        rows.process(&mut plane);
        let mut turned = vec![Complex::default(); w * h];
        for (i, v) in plane.iter().enumerate() {
            turned[i % w * h + i / w] = *v;
        }
        columns.process(&mut turned);
        for (i, v) in turned.iter().enumerate().skip(1) {
            let signed =
                |k: usize, n: usize| (if k > n / 2 { k as f64 - n as f64 } else { k as f64 }) / n as f64;
            let frequency = signed(i / h, w).hypot(signed(i % h, h));
            let ring = (frequency / 0.5 * RINGS as f64) as usize;
            if ring < RINGS {
                sums[ring].0 += v.norm_sqr() / ((w * h) as f64 * variance);
                sums[ring].1 += 1;
            }
        }
    }
    let centre = |ring: usize| (ring as f64 + 0.5) * 0.5 / RINGS as f64;
    let rings = sums.iter().enumerate().filter(|(_, (_, count))| *count > 0);
    rings.map(|(ring, (sum, count))| [centre(ring), sum / *count as f64]).collect()
}

/// The power of the pixels' courses over time, averaged over pixels.
fn temporal_power(values: &[f64], size: NoiseSize) -> Vec<[f64; 2]> {
    let frame = size.width * size.height;
    let fft = FftPlanner::new().plan_fft_forward(size.frames);
    let mut sums = vec![0.0; size.frames / 2 + 1];
    for pixel in 0..frame {
        let mut course: Vec<Complex<f64>> =
            (0..size.frames).map(|t| Complex::new(values[t * frame + pixel] - 0.5, 0.0)).collect();
        fft.process(&mut course);
        for (sum, v) in sums.iter_mut().zip(&course) {
            *sum += v.norm_sqr() * 12.0 / (size.frames * frame) as f64;
        }
    }
    sums.iter().enumerate().map(|(k, &p)| [k as f64 / size.frames as f64, p]).collect()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

fn deviation(values: &[f64]) -> f64 {
    let average = mean(values);
    (values.iter().map(|v| (v - average).powi(2)).sum::<f64>() / values.len().max(1) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::{Noise, NoiseKind, hash};

    fn carried() -> Vec<u32> {
        let noise = Noise::new(NoiseKind::Stbn, 0);
        let size = NoiseSize::STBN;
        (0..size.frames as u32)
            .flat_map(|t| {
                (0..size.height as u32).flat_map(move |y| (0..size.width as u32).map(move |x| (t, y, x)))
            })
            .map(|(t, y, x)| noise.frame(t).rank(x, y))
            .collect()
    }

    #[test]
    fn the_noise_that_the_program_carries_passes_every_check() {
        let report = check(&carried(), NoiseSize::STBN);
        let failed: Vec<&Check> = report.checks.iter().filter(|c| !c.passed).collect();
        assert!(failed.is_empty(), "{failed:?}");
    }

    #[test]
    fn white_noise_fails_the_checks_of_colour_but_not_of_count() {
        let size = NoiseSize::new(64, 64, 16).unwrap();
        let mut order: Vec<u32> = (0..size.len() as u32).collect();
        order.sort_by_key(|&i| hash(1, u64::from(i)));
        let report = check(&order, size);
        let failed: Vec<&str> = report.checks.iter().filter(|c| !c.passed).map(|c| c.name.as_str()).collect();
        assert!(failed.iter().any(|name| name.contains("spatial")), "{failed:?}");
        assert!(failed.iter().any(|name| name.contains("temporal")), "{failed:?}");
        assert!(!failed.iter().any(|name| name.contains("different")), "{failed:?}");
        let white =
            report.spatial_power.iter().map(|p| p[1]).sum::<f64>() / report.spatial_power.len() as f64;
        assert!((white - 1.0).abs() < 0.05, "{white}");
    }
}
