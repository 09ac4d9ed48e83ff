//! Pooling of differences to one number: Mantiuk et al. (2021), sections 4.6 and 4.7.

/// Exponent of the mean over pixels.
pub(crate) const OVER_PIXELS: f64 = 1.521_34;

/// Exponent of the sum over the two temporal channels.
const OVER_CHANNELS: f64 = 0.666_092;

/// Weight of the transient channel.
pub(crate) const TRANSIENT: f64 = 0.25;

/// JOD = 10 − a Q^b.
const JOD_A: f64 = 0.016_171_3;
const JOD_LOG_B: f64 = -0.228;

/// Difference of one band: the norm over `pixels`, given the `sum` of the powers.
pub(crate) fn band(sum: f64, pixels: usize) -> f64 {
    (sum / pixels as f64).powf(1.0 / OVER_PIXELS)
}

/// Difference of one frame, given both channels' sums over the bands.
pub(crate) fn frame([sustained, transient]: [f64; 2]) -> f64 {
    let sum = sustained.powf(OVER_CHANNELS) + (TRANSIENT * transient).powf(OVER_CHANNELS);
    sum.powf(1.0 / OVER_CHANNELS)
}

/// Loss in JOD below 10 for a pooled difference.
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
