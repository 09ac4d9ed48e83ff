use super::running_error::RunningError;

/// Error of the frames that are shown: against substitutes of the exact colours at many pixels, which are cheap, and what
/// that is wrong by, measured at few.
///
/// The sum is unbiased whatever the substitutes are (a control variate); it varies little where they are nearly exact.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ShownError {
    error: RunningError,
    correction: RunningError,
}

/// Weight of what was known of the correction, which hardly changes from frame to frame.
const MEMORY: f64 = 0.8;
/// Pixels that measure the error of a frame without what was known of the frames before it.
const ENOUGH: f64 = 1200.0;

impl ShownError {
    /// Adds the squared `errors` of a frame's pixels against exact colours.
    pub fn add(&mut self, errors: &[f64]) {
        self.correction = RunningError::default();
        self.error.add(errors.iter().copied(), memory(errors.len()));
    }

    /// Adds the squared `errors` of a frame's pixels against substitutes, and for the first of these pixels the errors
    /// against `exact` colours.
    pub fn add_substituted(&mut self, errors: &[f64], exact: &[f64]) {
        self.error.add(errors.iter().copied(), memory(errors.len()));
        self.correction.add(exact.iter().zip(errors).map(|(exact, error)| exact - error), MEMORY);
    }

    /// The mean squared error, if any is known.
    pub fn mean(&self) -> Option<f64> {
        let [mean, ..] = self.with_confidence()?;
        Some(mean)
    }

    /// Mean, and the bounds between which it lies with 95 % confidence.
    pub fn with_confidence(&self) -> Option<[f64; 3]> {
        RunningError::sum([self.error, self.correction])
    }
}

/// Weight of what was known, where `count` pixels measure the error of a frame. That of the frame before is often 2 dB away.
fn memory(count: usize) -> f64 {
    (1.0 - count as f64 / ENOUGH).clamp(0.3, 0.8)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers that look random, 0…1.
    fn numbers(seed: u64) -> impl Iterator<Item = f64> {
        let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
        std::iter::repeat_with(move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1u64 << 53) as f64
        })
    }

    #[test]
    fn substitutes_make_the_mean_surer_and_no_other() {
        // Few pixels have an error at all; substitutes are wrong by a little everywhere.
        let mut far = [0.0f64; 2];
        for seed in 1..200 {
            let exact: Vec<f64> = numbers(seed)
                .take(4096)
                .map(|number| if number < 0.02 { 50.0 * number } else { 0.0 })
                .collect();
            let truth = 0.01;
            let errors: Vec<f64> =
                exact.iter().zip(numbers(seed + 500)).map(|(e, n)| e + 0.004 * n).collect();
            let (mut plain, mut substituted) = (ShownError::default(), ShownError::default());
            plain.add(&exact[..256]);
            substituted.add_substituted(&errors, &exact[..256]);
            far[0] += (plain.mean().unwrap() - truth).powi(2);
            far[1] += (substituted.mean().unwrap() - truth).powi(2);
        }
        assert!(far[1] < far[0] / 8.0, "{far:?}");
    }

    #[test]
    fn exact_colours_leave_no_correction() {
        let mut error = ShownError::default();
        assert_eq!(error.mean(), None);
        error.add_substituted(&[3.0; 100], &[4.0; 10]);
        assert!((error.mean().unwrap() - 4.0).abs() < 1e-9);
        error.add(&[0.0; 2000]);
        error.add(&[0.0; 2000]);
        assert!(error.mean().unwrap() < 0.1);
    }
}
