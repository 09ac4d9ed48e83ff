//! Visible differences under masking within and across channels: Mantiuk et al. (2024), section 3.4.

use super::power::Power;

/// Gain of the contrasts of each channel.
pub(crate) const CONTRAST: [f32; 4] = [1.0, 1.45, 1.0, 1.0];

/// Exponent of a difference.
const DIFFERENCE: f32 = 2.264_355_2;

/// Exponents of the masking contrasts, by channel.
const MASK: [f32; 4] = [1.302_622_7, 2.888_590_8, 3.680_771_4, 3.588_787_3];

/// Gain of the masking contrasts, as an exponent of 10.
const MASK_GAIN: f32 = -0.795_497_1;

/// Weights with which the channel of the row masks the channel of the column, as exponents of 2.
const ACROSS: [[f32; 4]; 4] = [
    [-0.189_501_05, -5.962_151, -4.318_346, -1.932_158_7],
    [2.565_559_4, 0.344_067_13, -2.719_646_5, -0.497_042_48],
    [3.811_837_2, -1.005_170_6, -0.519_337_65, -0.565_364_8],
    [-7.054_771_4, -5.527_150_6, -3.510_641_8, -2.088_05],
];

/// Largest difference, as an exponent of 10.
const MOST: f32 = 2.564_245_5;

/// Masking of up to four channels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Masking {
    difference: Power,
    mask: [Power; 4],
    gain: f32,
    across: [[f32; 4]; 4],
    most: f32,
}

impl Masking {
    pub fn new() -> Self {
        Self {
            difference: Power::new(DIFFERENCE),
            mask: MASK.map(Power::new),
            gain: 10_f32.powf(MASK_GAIN),
            across: ACROSS.map(|row| row.map(f32::exp2)),
            most: 10_f32.powf(MOST),
        }
    }

    /// Visible differences of one row. `differences` holds the absolute differences of each channel and is replaced;
    /// `masks` holds the contrasts that both pictures share, and is used up. Both have one row per channel.
    pub fn apply(&self, differences: &mut [Vec<f32>], masks: &mut [Vec<f32>], total: &mut [f32]) {
        for (mask, power) in masks.iter_mut().zip(self.mask) {
            mask.iter_mut().for_each(|v| *v = power.of(*v * self.gain));
        }
        for (channel, differences) in differences.iter_mut().enumerate() {
            total.fill(1.0);
            for (mask, weights) in masks.iter().zip(&self.across) {
                let weight = weights[channel];
                total.iter_mut().zip(mask).for_each(|(total, mask)| *total += weight * mask);
            }
            for (value, total) in differences.iter_mut().zip(total.iter()) {
                let seen = self.difference.of(*value) / total;
                *value = self.most * seen / (self.most + seen);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Visible differences of one pixel.
    fn seen(differences: [f32; 4], masks: [f32; 4]) -> [f32; 4] {
        let mut differences = differences.map(|v| vec![v]);
        let mut masks = masks.map(|v| vec![v]);
        Masking::new().apply(&mut differences, &mut masks, &mut [0.0]);
        differences.map(|v| v[0])
    }

    #[test]
    fn without_a_mask_a_difference_at_threshold_is_about_one() {
        let found = seen([1.0, 0.0, 2.0, 1e9], [0.0; 4]);
        assert!((found[0] - 0.9973).abs() < 1e-3 && found[1] == 0.0, "{found:?}");
        assert!((found[2] - 4.74).abs() < 0.02, "{found:?}");
        assert!((found[3] - 366.65).abs() < 0.1, "{found:?}");
    }

    #[test]
    fn contrast_in_any_channel_hides_differences_in_all() {
        let plain = seen([1.0; 4], [0.0; 4]);
        for channel in 0..4 {
            let mut masks = [0.0; 4];
            masks[channel] = 40.0;
            let masked = seen([1.0; 4], masks);
            assert!(masked.iter().zip(plain).all(|(m, p)| *m < p), "{masked:?}");
        }
    }
}
