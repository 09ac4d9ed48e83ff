//! From differences to one number: Mantiuk et al. (2021), sections 4.6 and 4.7.

/// The exponent over pixels, as a mean.
pub(crate) const OVER_PIXELS: f64 = 1.521_34;

/// The exponent over the two temporal channels, as a sum.
const OVER_CHANNELS: f64 = 0.666_092;

/// The weight of the transient channel.
pub(crate) const TRANSIENT: f64 = 0.25;

/// JOD = 10 − a Q^b.
const JOD_A: f64 = 0.016_171_3;
const JOD_LOG_B: f64 = -0.228;

/// The difference of one band: the norm over `pixels` of which `sum` is the sum of the powers.
pub(crate) fn band(sum: f64, pixels: usize) -> f64 {
    (sum / pixels as f64).powf(1.0 / OVER_PIXELS)
}

/// The difference of one frame from the sums over the bands of both channels.
pub(crate) fn frame([sustained, transient]: [f64; 2]) -> f64 {
    let sum = sustained.powf(OVER_CHANNELS) + (TRANSIENT * transient).powf(OVER_CHANNELS);
    sum.powf(1.0 / OVER_CHANNELS)
}

/// How many JOD a difference is below 10.
pub(crate) fn loss(difference: f64) -> f64 {
    JOD_A * difference.powf(10_f64.powf(JOD_LOG_B))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_difference_costs_nothing() {
        assert_eq!(loss(frame([band(0.0, 7), band(0.0, 7)])), 0.0);
    }

    #[test]
    fn what_only_the_sustained_channel_sees_passes_the_channels_unchanged() {
        assert!((frame([3.0, 0.0]) - 3.0).abs() < 1e-12);
        // Spot value of the published program.
        assert!((loss(0.0015791 + 1.5716389) - (10.0 - 9.978857)).abs() < 1e-6);
    }

    #[test]
    fn equal_pixels_have_their_own_norm() {
        assert!((band(10.0 * 5_f64.powf(OVER_PIXELS), 10) - 5.0).abs() < 1e-12);
    }
}
