//! Colour of NaN in transfer functions.

use super::TransferFunction;
use crate::{Error, Result};

impl TransferFunction {
    /// Sets colour and opacity `nan` (r, g, b, a) of NaN.
    ///
    /// # Errors
    /// A number outside [0, 1].
    pub fn with_nan(mut self, nan: [f64; 4]) -> Result<Self> {
        if nan.iter().any(|x| !(0.0..=1.0).contains(x)) {
            return Err(Error::TransferFunction(
                "the colour of NaN has a number outside [0, 1]; give r, g, b and a between 0 and 1".into(),
            ));
        }
        self.nan = Some(nan);
        Ok(self)
    }

    /// Removes the colour of NaN, which becomes transparent.
    #[must_use]
    pub fn without_nan(mut self) -> Self {
        self.nan = None;
        self
    }

    /// Colour and opacity of NaN, if set.
    pub fn chosen_nan(&self) -> Option<[f64; 4]> {
        self.nan
    }

    /// Colour and opacity `[r, g, b, a]` of NaN; transparent if not set.
    pub fn nan(&self) -> [f64; 4] {
        self.nan.unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nan_keeps_its_colour() {
        let red = [1.0, 0.2, 0.0, 0.5];
        let tf = TransferFunction::grey_ramp(1.0).with_range(Some([0.0, 10.0])).unwrap();
        assert_eq!(tf.evaluate(f64::NAN), [0.0; 4]);
        let tf = tf.with_nan(red).unwrap();
        let text = serde_json::to_string(&tf).unwrap();
        assert!(text.contains("\"nan\":[1.0,0.2,0.0,0.5]"), "{text}");
        let log = tf.on_log_scale([0.0, 1000.0], 1.0).unwrap();
        for tf in [serde_json::from_str(&text).unwrap(), tf.over([2.0, 4.0]), tf.over([3.0, 3.0]), log] {
            assert_eq!((tf.evaluate(f64::NAN), tf.chosen_nan()), (red, Some(red)));
        }
        assert_eq!(tf.clone().without_nan().nan(), [0.0; 4]);
        for bad in [[0.0, 0.0, 0.0, 1.1], [-0.1, 0.0, 0.0, 1.0], [f64::NAN; 4]] {
            assert!(tf.clone().with_nan(bad).unwrap_err().to_string().contains("between 0 and 1"));
        }
    }
}
