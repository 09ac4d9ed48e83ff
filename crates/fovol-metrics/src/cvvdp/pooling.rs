//! Pooling of differences to one number: Mantiuk et al. (2024), sections 3.5 and 3.6.

use super::power::power;

/// Exponent of the mean over pixels and over frames.
const OVER_PIXELS: f64 = 2.0;

/// Exponent of the sum over bands and over channels.
const OVER_BANDS: f64 = 4.0;

/// Weights of the channels.
const CHANNELS: [f64; 4] = [1.0, 1.0, 1.0, 0.808_113_455_772_399_9];

/// Further weights of the channels in the base.
const BASE: [f64; 4] =
    [0.003_633_448_621_258_139_6, 1.662_772_417_068_481_4, 4.118_745_326_995_85, 25.259_698_867_797_85];

/// Factor of pictures, which are looked at for longer than a frame.
const PICTURE: f64 = 0.577_918_291_091_919;

/// JOD = 10 − a Q^b.
const JOD_A: f64 = 0.043_956_939_131_021_5;
const JOD_B: f64 = 0.930_204_272_270_202_6;

/// Differences below this one cost in proportion.
const LINEAR: f64 = 0.1;

/// Value of a pixel's difference in the sum that [`band`] takes.
#[inline(always)]
pub(crate) fn pixel(difference: f32) -> f32 {
    // (d + s)² − s²
    difference * (difference + 2.0 * super::power::SHIFT as f32)
}

/// Difference of one channel in one band, given the sum of [`pixel`] over its pixels.
pub(crate) fn band(sum: f64, pixels: usize) -> f64 {
    power(sum / pixels as f64, 1.0 / OVER_PIXELS)
}

/// Difference of one frame. Each row of `bands` holds the differences of the channels in one band, finest first; the
/// last row is the base.
pub(crate) fn frame(bands: &[[f64; 4]]) -> f64 {
    let channels = [0, 1, 2, 3].map(|channel| {
        norm(bands.iter().enumerate().map(|(level, band)| {
            let base = if level + 1 == bands.len() { BASE[channel] } else { 1.0 };
            band[channel] * CHANNELS[channel] * base
        }))
    });
    norm(channels.into_iter())
}

/// Value of a frame of a clip in the sum that [`clip`] takes.
pub(crate) fn moment(difference: f64) -> f64 {
    power(difference, OVER_PIXELS)
}

/// Difference of a clip of `frames` frames, given the sum of [`moment`] over them.
pub(crate) fn clip(sum: f64, frames: usize) -> f64 {
    power(sum / frames as f64, 1.0 / OVER_PIXELS)
}

/// Difference of a picture that is seen without time.
pub(crate) fn picture(difference: f64) -> f64 {
    difference * PICTURE
}

/// Loss in JOD below 10 for a pooled difference.
pub(crate) fn loss(difference: f64) -> f64 {
    if difference <= LINEAR {
        JOD_A * LINEAR.powf(JOD_B - 1.0) * difference
    } else {
        JOD_A * difference.powf(JOD_B)
    }
}

fn norm(values: impl Iterator<Item = f64>) -> f64 {
    power(values.map(|v| power(v, OVER_BANDS)).sum(), 1.0 / OVER_BANDS)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_difference_costs_nothing() {
        assert_eq!(pixel(0.0), 0.0);
        let bands = [[band(0.0, 7); 4]; 3];
        assert_eq!(loss(clip(moment(frame(&bands)), 1)), 0.0);
    }

    #[test]
    fn equal_pixels_frames_and_single_bands_keep_their_difference() {
        let sum = 10.0 * f64::from(pixel(5.0));
        assert!((band(sum, 10) - 5.0).abs() < 5e-3);
        assert!((frame(&[[5.0, 0.0, 0.0, 0.0], [0.0; 4]]) - 5.0).abs() < 0.2);
        assert!((clip(3.0 * moment(5.0), 3) - 5.0).abs() < 5e-3);
    }

    #[test]
    fn the_loss_is_continuous_and_grows() {
        let losses = [0.0, 0.05, 0.0999, 0.1, 0.1001, 1.0, 50.0].map(loss);
        assert!(losses.is_sorted());
        assert!((losses[4] - losses[2]) < 2e-5);
        assert!((losses[5] - JOD_A).abs() < 1e-12);
    }
}
