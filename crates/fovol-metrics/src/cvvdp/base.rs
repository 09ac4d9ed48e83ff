//! The base of the pyramid: differences of brightness and colour over large areas.

use super::band::{DARKEST, MOST};
use super::pooling::pixel;
use super::sensitivity::Sensitivity;
use crate::planes::Plane;
use crate::vdp::log_math::exp2;
use crate::vdp::pyramid::Pyramid;

/// Frequency at which the base is judged, in cycles per degree.
pub(crate) const FREQUENCY: f64 = 0.1;

/// Sums of the differences of the base's pixels, per channel. Values are relative to the mean luminance of their
/// picture. The base is the coarsest level, `level`, of the pyramids of reference and test.
pub(crate) fn sums(pyramids: &[Vec<Pyramid>; 2], level: usize, sensitivity: &Sensitivity) -> [f64; 4] {
    let means = [0, 1].map(|side: usize| mean(pyramids[side][0].level(level)));
    let logs = sensitivity.at(means[0].log2());
    let scales = means.map(|mean| 1.0 / mean);
    let mut sums = [0.0; 4];
    for (channel, (reference, test)) in pyramids[0].iter().zip(&pyramids[1]).enumerate() {
        let factor = exp2(logs[channel]);
        let pairs = reference.level(level).values.iter().zip(&test.level(level).values);
        let differences =
            pairs.map(|(r, t)| ((t * scales[1]).min(MOST) - (r * scales[0]).min(MOST)).abs() * factor);
        sums[channel] = differences.map(|v| f64::from(pixel(v))).sum();
    }
    sums
}

/// Mean luminance of a level, at least [`DARKEST`] at each pixel.
fn mean(plane: &Plane) -> f32 {
    let sum: f64 = plane.values.iter().map(|v| f64::from(v.max(DARKEST))).sum();
    (sum / plane.values.len() as f64) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    fn flat(values: [f32; 3]) -> Vec<Pyramid> {
        let flat = |value: f32| {
            let mut pyramid = Pyramid::new(2, 2, 1);
            pyramid.finest_mut().values.fill(value);
            pyramid
        };
        values.map(flat).into()
    }

    #[test]
    fn brightness_counts_relative_to_its_mean_and_colour_relative_to_brightness() {
        let sensitivity = Sensitivity::new(FREQUENCY);
        let sums = |a, b| sums(&[flat(a), flat(b)], 0, &sensitivity);
        assert_eq!(sums([50.0, 1.0, 2.0], [50.0, 1.0, 2.0]), [0.0; 4]);
        let brighter = sums([50.0, 1.0, 2.0], [100.0, 2.0, 4.0]);
        assert!(brighter.iter().all(|&v| v < 1e-6), "{brighter:?}");
        let redder = sums([50.0, 1.0, 2.0], [50.0, 6.0, 2.0]);
        assert!(redder[1] > 1.0 && redder[0] == 0.0 && redder[2] == 0.0, "{redder:?}");
    }
}
