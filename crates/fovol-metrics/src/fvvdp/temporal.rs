//! Temporal channels: Mantiuk et al. (2021), section 4.2.

/// Length of the filters, in seconds.
const SECONDS: f64 = 0.25;

/// Peak time of the sustained filter, in seconds.
const PEAK: f64 = 0.06;

/// Width of the sustained filter: standard deviation of the logarithm of time.
const WIDTH: f64 = 0.5;

/// Gain of the transient filter, in seconds.
const TRANSIENT_GAIN: f64 = 0.062_170_5;

/// Causal temporal filters; the first tap is the present frame.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct TemporalFilters {
    /// Taps of the sustained and of the transient channel.
    pub taps: Vec<[f32; 2]>,
}

impl TemporalFilters {
    /// Filters for `fps` frames a second, ⌈fps / 4⌉ taps long.
    ///
    /// The sustained filter is log-normal with sum 1, the transient filter its derivative. Up to 4 frames a second,
    /// one tap is left: frames are judged independently, and the transient channel is zero.
    pub fn new(fps: f64) -> Self {
        let count = (SECONDS * fps).ceil() as usize;
        let step = count as f64 / fps / (count.max(2) - 1) as f64;
        let bump = |i: usize| {
            let octaves = (i as f64 * step + 1e-4).ln() - PEAK.ln();
            (-octaves * octaves / (2.0 * WIDTH * WIDTH)).exp()
        };
        let sum: f64 = (0..count).map(bump).sum();
        let sustained = |i: usize| bump(i) / sum;
        let transient = |i: usize| {
            if i + 1 < count { TRANSIENT_GAIN * (sustained(i + 1) - sustained(i)) / step } else { 0.0 }
        };
        Self { taps: (0..count).map(|i| [sustained(i) as f32, transient(i) as f32]).collect() }
    }

    /// Filter for pictures: the sustained channel is the picture itself.
    pub fn still() -> Self {
        Self { taps: vec![[1.0, 0.0]] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_taps_at_30_frames_a_second_are_the_published_ones() {
        let sustained = [0.0, 0.29229, 0.39163, 0.19115, 0.07716, 0.0304, 0.01225, 0.00512];
        let transient = [0.47702, 0.16211, -0.32717, -0.18603, -0.07631, -0.02962, -0.01163, 0.0];
        let filters = TemporalFilters::new(30.0);
        assert_eq!(filters.taps.len(), 8);
        for (tap, expected) in filters.taps.iter().zip(sustained.into_iter().zip(transient)) {
            assert!((tap[0] - expected.0).abs() < 1e-5 && (tap[1] - expected.1).abs() < 1e-5, "{tap:?}");
        }
    }

    #[test]
    fn slow_and_fast_clips_have_filters_too() {
        for (fps, count) in [(0.5, 1), (4.0, 1), (5.0, 2), (23.976, 6), (60.0, 15), (120.0, 30)] {
            let filters = TemporalFilters::new(fps);
            assert_eq!(filters.taps.len(), count, "{fps}");
            let sum: f32 = filters.taps.iter().map(|tap| tap[0]).sum();
            assert!((sum - 1.0).abs() < 1e-6);
        }
        assert_eq!(TemporalFilters::new(2.0), TemporalFilters::still());
    }
}
