//! Powers as the metric is fitted with: their slope at zero is finite.

use crate::vdp::log_math::{exp2, log2};

/// Shift of every base.
pub(crate) const SHIFT: f64 = 1e-5;

/// (x + [`SHIFT`])^p − [`SHIFT`]^p for x ≥ 0; 0 for 0.
pub(crate) fn power(x: f64, p: f64) -> f64 {
    (x + SHIFT).powf(p) - SHIFT.powf(p)
}

/// Shifted power of many values with one exponent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Power {
    exponent: f32,
    offset: f32,
}

impl Power {
    pub fn new(exponent: f32) -> Self {
        Self { exponent, offset: exp2(exponent * log2(SHIFT as f32)) }
    }

    /// Shifted power of `x` ≥ 0.
    #[inline(always)]
    pub fn of(self, x: f32) -> f32 {
        exp2(self.exponent * log2(x + SHIFT as f32)) - self.offset
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_forms_agree_and_are_zero_at_zero() {
        for exponent in [0.5, 1.302_622_7, 2.264_355_2, 4.0] {
            let many = Power::new(exponent);
            assert_eq!((many.of(0.0), power(0.0, exponent.into())), (0.0, 0.0));
            for x in [1e-6_f32, 1e-3, 0.2, 1.0, 30.0, 5e4] {
                let (found, expected) = (f64::from(many.of(x)), power(x.into(), exponent.into()));
                assert!((found / expected - 1.0).abs() < 1e-4, "{x}^{exponent}: {found} {expected}");
            }
        }
    }
}
