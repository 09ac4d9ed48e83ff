//! Errors of frames by their size.

/// Errors of frames of every scale, known from one frame that was shown.
///
/// A frame that is made smaller again differs from itself by about as much as a smaller frame would differ from it. That needs no
/// marching, and all of the frame counts. Larger frames follow the power law between what is known.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SizeErrors {
    known: Option<Known>,
}

#[derive(Debug, Clone, PartialEq)]
struct Known {
    /// Scale of the frame, and its mean squared error by its size.
    scale: f64,
    error: f64,
    /// Errors that [`RATIOS`] of its size add.
    smaller: [f64; RATIOS.len()],
}

/// Factors of a frame's size at which it is compared with itself.
pub const RATIOS: [f64; 3] = [0.75, 0.5, 0.3333];

/// Scales and errors before any was measured.
const GUESS: [(f64, f64); 4] = [(0.75, 1e-5), (0.5, 4e-5), (0.3333, 1e-4), (0.2, 4e-4)];
/// Scale above which errors hardly fall, and their power of the size there: edges never get sharp again. Measured on three volumes.
const NEARLY_WHOLE: (f64, f64) = (0.75, 0.35);
/// Bounds of the power of the size by which errors fall.
const POWERS: [f64; 2] = [0.3, 2.0];
/// Factor of the difference between a whole frame and itself made smaller: what lies between its pixels is not in it.
const BETWEEN_PIXELS: f64 = 1.3;
/// Smallest part of an error that sizes are taken to have.
const LEAST: f64 = 1e-9;
/// Weight of what was known of frames of the same scale.
const MEMORY: f64 = 0.5;

impl SizeErrors {
    /// Takes the `error` that frames of `scale` have by their size, and the differences that [`RATIOS`] of their size make.
    pub fn see(&mut self, scale: f64, error: f64, smaller: [f64; RATIOS.len()]) {
        let new = Known { scale, error, smaller };
        self.known = Some(match self.known.take().filter(|old| old.scale == scale) {
            Some(old) => old.mixed(&new),
            None => new,
        });
    }

    /// Error of frames of `scale`.
    pub fn at(&self, scale: f64) -> f64 {
        if scale >= 1.0 {
            return 0.0;
        }
        let points = self.known.as_ref().map_or_else(|| GUESS.to_vec(), Known::points);
        // The pair of points around the scale, or the nearest one.
        let below = points.iter().position(|(known, _)| *known <= scale).unwrap_or(points.len() - 1);
        let pair = [below.max(1) - 1, below.max(1)].map(|i| points[i]);
        let power = power(pair);
        let (from, error) = if below == 0 { pair[0] } else { pair[1] };
        let (limit, slow) = NEARLY_WHOLE;
        if scale <= limit || below > 0 {
            return error * (size(scale) / size(from)).powf(power);
        }
        let first = from.max(limit);
        error * (size(first) / size(from)).powf(power) * (size(scale) / size(first)).powf(slow)
    }
}

impl Known {
    fn mixed(&self, new: &Self) -> Self {
        let mix = |old: f64, new: f64| MEMORY * old + (1.0 - MEMORY) * new;
        let smaller = std::array::from_fn(|i| mix(self.smaller[i], new.smaller[i]));
        Self { scale: self.scale, error: mix(self.error, new.error), smaller }
    }

    /// Scales with their errors, which grow from each to the next.
    fn points(&self) -> Vec<(f64, f64)> {
        let is_whole = self.scale >= 1.0;
        let own = (!is_whole).then_some((self.scale, self.error.max(LEAST)));
        let factor = if is_whole { BETWEEN_PIXELS } else { 1.0 };
        let mut points: Vec<(f64, f64)> = own.into_iter().collect();
        for (ratio, smaller) in RATIOS.into_iter().zip(self.smaller) {
            let before = points.last().map_or(LEAST, |(_, error)| *error);
            points.push((self.scale * ratio, (self.error + factor * smaller).max(before)));
        }
        points
    }
}

/// By how much frames of `scale` are smaller; errors are power laws of it.
fn size(scale: f64) -> f64 {
    1.0 / scale - 1.0
}

/// Power of the size by which errors grow between two points.
fn power([near, far]: [(f64, f64); 2]) -> f64 {
    ((far.1 / near.1).ln() / (size(far.0) / size(near.0)).ln()).clamp(POWERS[0], POWERS[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_fall_with_the_size_and_whole_frames_have_none() {
        let mut errors = SizeErrors::default();
        for scale in [None, Some(1.0), Some(0.5), Some(0.1)] {
            if let Some(scale) = scale {
                errors.see(scale, if scale < 1.0 { 3e-5 } else { 0.0 }, [1e-5, 4e-5, 9e-5]);
            }
            let all: Vec<f64> = (1..=20).map(|i| errors.at(f64::from(i) / 20.0)).collect();
            assert!(all.windows(2).all(|pair| pair[1] <= pair[0] * 1.0001), "{scale:?}: {all:?}");
            assert!(all[19] == 0.0 && all[18] > 0.0);
        }
    }

    #[test]
    fn frames_like_the_one_that_is_known_have_its_error() {
        let mut errors = SizeErrors::default();
        errors.see(0.5, 2e-5, [1e-5, 3e-5, 8e-5]);
        assert!((errors.at(0.5) - 2e-5).abs() < 1e-12);
        assert!((errors.at(0.25) - 5e-5).abs() < 1e-12);
        errors.see(0.5, 4e-5, [1e-5, 3e-5, 8e-5]);
        assert!((errors.at(0.5) - 3e-5).abs() < 1e-12);
        errors.see(1.0, 0.0, [1e-5, 3e-5, 8e-5]);
        assert!((errors.at(0.75) - 1.3e-5).abs() < 1e-12);
    }
}
