use fovol_metrics::psnr_of_mse;

/// Mean squared error over pixels drawn at random, of which older ones count less.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RunningError {
    /// Weights of all errors, and of their squares.
    weight: f64,
    square_weight: f64,
    /// Weighted sums of the errors, and of their squares.
    sum: f64,
    squares: f64,
}

/// Standard deviations on each side of the mean. Between 1.96 of them lie 95 % of normal means; squared errors have heavy tails,
/// and there lay the truth in 84 of 100 frames.
const CONFIDENCE: f64 = 2.6;
/// Smallest part of an error that it may be, by its confidence.
const LEAST: f64 = 0.1;

impl RunningError {
    /// Adds the squared `errors` of pixels; what was known before counts `memory` as much, 0…1.
    pub fn add(&mut self, errors: impl IntoIterator<Item = f64>, memory: f64) {
        self.weight *= memory;
        self.square_weight *= memory * memory;
        self.sum *= memory;
        self.squares *= memory;
        for error in errors {
            self.weight += 1.0;
            self.square_weight += 1.0;
            self.sum += error;
            self.squares += error * error;
        }
    }

    /// The mean squared error, if any is known.
    pub fn mean(&self) -> Option<f64> {
        (self.weight > 0.0).then(|| self.sum / self.weight)
    }

    /// Sum of the means of those `errors` that are known, and the bounds between which it lies with 95 % confidence.
    pub fn sum(errors: [Self; 2]) -> Option<[f64; 3]> {
        let known = || errors.iter().filter_map(|error| Some((error.mean()?, error.variance_of_mean())));
        known().next()?;
        // Corrections that chance made too large leave no error below 0.
        let mean = known().map(|(mean, _)| mean).sum::<f64>().max(0.0);
        let deviation = known().map(|(_, variance)| variance).sum::<f64>().sqrt();
        let least = (mean - CONFIDENCE * deviation).max(LEAST * mean);
        Some([mean, least, mean + CONFIDENCE * deviation])
    }

    /// Variance of the mean.
    fn variance_of_mean(&self) -> f64 {
        let mean = self.sum / self.weight;
        let variance = (self.squares / self.weight - mean * mean).max(0.0);
        variance * self.square_weight / (self.weight * self.weight)
    }
}

/// PSNR in dB of a part `share` of a frame that has the mean squared error `mse`; the rest has none.
pub fn psnr_of_part(mse: f64, share: f64) -> f64 {
    psnr_of_mse((mse * share).max(1e-12))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn new_errors_replace_old_ones() {
        let mut error = RunningError::default();
        assert_eq!(RunningError::sum([error; 2]), None);
        error.add([4.0; 100], 0.8);
        for _ in 0..40 {
            error.add([1.0; 100], 0.8);
        }
        assert!((error.mean().unwrap() - 1.0).abs() < 1e-3);
        assert!((psnr_of_part(0.01, 0.1) - 30.0).abs() < 1e-9 && psnr_of_part(0.0, 0.5) > 99.0);
    }

    proptest! {
        #[test]
        fn the_truth_lies_within_the_confidence(seed in 0u64..500) {
            // Errors of 1 in a tenth of the pixels: their mean is 0.1.
            let mut error = RunningError::default();
            let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
            for _ in 0..6 {
                error.add(std::iter::repeat_with(|| {
                    state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                    f64::from(u8::from((state >> 33) % 10 == 0))
                }).take(512), 0.8);
            }
            let [mean, least, most] =
                RunningError::sum([error, RunningError::default()]).unwrap();
            // Twice the interval holds the truth in all but one of 10,000 cases.
            prop_assert!(least <= mean && mean <= most);
            prop_assert!((mean - 0.1).abs() <= 2.0 * (most - mean));
        }
    }
}
