//! Temporal filters of the four channels: Mantiuk et al. (2024), section 3.2.

use std::f64::consts::PI;

/// Length of the filters, in seconds.
const SECONDS: f64 = 0.25;

/// Fall-off of the sustained filters and bandwidth of the transient one: achromatic, red-green, violet-yellow,
/// achromatic transient.
const SIGMA: [f64; 4] = [5.793_36, 14.125_5, 6.636_61, 0.123_14];

/// Exponents of the temporal frequency, by channel.
const BETA: [f64; 4] = [1.331_4, 1.119_6, 0.947_901, 0.189_8];

/// Temporal frequency at the peak of the transient filter, in Hz.
const PEAK: f64 = 5.0;

/// Temporal filters; the first tap is the present frame. They are symmetric, so a filter's centre lies an eighth of a
/// second back.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct TemporalFilters {
    /// Taps of the sustained and of the transient filter for the achromatic channel.
    pub light: Vec<[f32; 2]>,
    /// Taps of the red-green and of the violet-yellow channel.
    pub colour: [Vec<[f32; 1]>; 2],
}

impl TemporalFilters {
    /// Filters for `fps` frames a second, 2⌈fps / 8⌉ + 1 taps long: at least three.
    pub fn new(fps: f64) -> Self {
        let [steady, red_green, violet_yellow, change] = [0, 1, 2, 3].map(|channel| taps(channel, fps));
        let single = |taps: Vec<f32>| taps.into_iter().map(|v| [v]).collect();
        Self {
            light: steady.into_iter().zip(change).map(|(a, b)| [a, b]).collect(),
            colour: [single(red_green), single(violet_yellow)],
        }
    }

    /// Number of frames that the filters reach back, the present one included.
    pub fn len(&self) -> usize {
        self.light.len()
    }
}

/// Response of the filter of `channel` at `omega` Hz.
fn response(channel: usize, omega: f64) -> f64 {
    let (sigma, beta) = (SIGMA[channel], BETA[channel]);
    if channel < 3 {
        (-omega.powf(beta) / sigma).exp()
    } else {
        (-(omega.powf(beta) - PEAK.powf(beta)).powi(2) / sigma).exp()
    }
}

/// Taps of one filter: the inverse Fourier transform of its response, with the centre in the middle.
fn taps(channel: usize, fps: f64) -> Vec<f32> {
    let half = (SECONDS * fps / 2.0).ceil() as usize;
    let count = 2 * half + 1;
    // The published program spreads the frequencies up to half the frame rate.
    let responses: Vec<f64> =
        (0..=half).map(|k| response(channel, fps / 2.0 * k as f64 / half as f64)).collect();
    let tap = |i: usize| {
        let turn = 2.0 * PI * (i as f64 - half as f64) / count as f64;
        let waves: f64 = (1..=half).map(|k| 2.0 * responses[k] * (turn * k as f64).cos()).sum();
        ((responses[0] + waves) / count as f64) as f32
    };
    (0..count).map(tap).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Taps at 30 frames a second from the middle on: achromatic, red-green, violet-yellow, transient.
    const TAPS_30: [[f32; 4]; 5] = [
        [0.213_727, 0.514_909, 0.403_663, 0.661_264],
        [0.174_81, 0.169_03, 0.171_251, 0.031_386],
        [0.107_367, 0.034, 0.057_371, -0.150_022],
        [0.064_189, 0.024_257, 0.039_636, -0.110_338],
        [0.046_771, 0.015_257, 0.029_911, -0.101_657],
    ];

    #[test]
    fn the_taps_at_30_frames_a_second_are_the_published_ones() {
        let filters = TemporalFilters::new(30.0);
        assert_eq!(filters.len(), 9);
        for (i, [steady, red_green, violet_yellow, change]) in TAPS_30.into_iter().enumerate() {
            let back = 4 + i;
            let found = [
                filters.light[back][0],
                filters.colour[0][back][0],
                filters.colour[1][back][0],
                filters.light[back][1],
            ];
            let expected = [steady, red_green, violet_yellow, change];
            assert!(found.iter().zip(expected).all(|(f, e)| (f - e).abs() < 1e-5), "{found:?} {expected:?}");
        }
    }

    #[test]
    fn filters_are_symmetric_and_keep_what_stays() {
        for (fps, count) in
            [(0.5, 3), (4.0, 3), (23.976, 7), (24.0, 7), (60.0, 17), (120.0, 31), (1000.0, 251)]
        {
            let filters = TemporalFilters::new(fps);
            assert_eq!(filters.len(), count, "{fps}");
            for channel in 0..4 {
                let taps = taps(channel, fps);
                assert!(taps.iter().zip(taps.iter().rev()).all(|(a, b)| (a - b).abs() < 1e-6));
                let sum: f32 = taps.iter().sum();
                let kept = if channel < 3 { 1.0 } else { 0.0 };
                assert!((sum - kept).abs() < 1e-4, "{fps} {channel}: {sum}");
            }
        }
    }
}
