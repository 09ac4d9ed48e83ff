//! Temporal channels: Mantiuk et al. (2021), section 4.2.

use std::collections::VecDeque;

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

/// Luminance of the last frames, newest first.
#[derive(Debug, Clone, Default)]
pub(crate) struct History(VecDeque<Vec<f32>>);

impl History {
    /// Returns a plane to be filled and pushed: the oldest plane if the window of `length` frames is full, else a new
    /// one.
    pub fn recycle(&mut self, length: usize, pixels: usize) -> Vec<f32> {
        let old = if self.0.len() >= length { self.0.pop_back() } else { None };
        old.unwrap_or_else(|| vec![0.0; pixels])
    }

    pub fn push(&mut self, plane: Vec<f32>) {
        self.0.push_front(plane);
    }

    /// Luminance of the present frame.
    ///
    /// # Panics
    /// Before the first frame.
    pub fn newest(&self) -> &[f32] {
        self.plane(0)
    }

    /// Plane of `back` frames ago. Frames before the first equal the first.
    fn plane(&self, back: usize) -> &[f32] {
        &self.0[back.min(self.0.len() - 1)]
    }

    /// Filters the pixels from `start` on into both channels.
    pub fn filter(&self, filters: &TemporalFilters, start: usize, out: [&mut [f32]; 2]) {
        let [sustained, transient] = out;
        sustained.fill(0.0);
        transient.fill(0.0);
        for (back, &[steady, change]) in filters.taps.iter().enumerate() {
            let values = &self.plane(back)[start..start + sustained.len()];
            for i in 0..values.len() {
                sustained[i] += steady * values[i];
                transient[i] += change * values[i];
            }
        }
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

    #[test]
    fn the_first_frame_stands_for_those_before_it() {
        let mut history = History::default();
        let filters = TemporalFilters::new(12.0);
        for value in [1.0, 2.0, 3.0, 4.0] {
            let mut plane = history.recycle(filters.taps.len(), 1);
            plane.fill(value);
            history.push(plane);
        }
        assert_eq!(history.0, [[4.0], [3.0], [2.0]]);
        let mut first = History::default();
        first.push(vec![5.0]);
        let (mut steady, mut change) = ([0.0], [0.0]);
        first.filter(&filters, 0, [&mut steady, &mut change]);
        assert!((steady[0] - 5.0).abs() < 1e-5);
    }
}
