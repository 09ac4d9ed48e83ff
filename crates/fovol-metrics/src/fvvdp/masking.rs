//! Visibility of differences under masking: Mantiuk et al. (2021), section 4.5. Computed in logarithms to base 2,
//! where powers become products.

use crate::vdp::log_math::{exp2, log2};

/// Exponent of a difference.
const DIFFERENCE: f32 = 2.4;

/// Exponents of the masking contrast for the sustained and the transient channel.
pub(crate) const MASKING: [f32; 2] = [2.43685, 4.946];

/// log₂ of the factor of the masking contrast, 10^−0.973838.
const MASK_GAIN: f32 = -0.973_838 * std::f32::consts::LOG2_10;

/// log₂ of the largest difference, 10⁴.
const MOST: f32 = 4.0 * std::f32::consts::LOG2_10;

/// Replaces zero in logarithms.
const TINY: f32 = 1e-30;

/// log₂ of the visible difference between two contrasts; `f32::MIN` for equal ones.
///
/// The formula is (|t − r| S)^2.4 / (1 + (k · min(|r|, |t|) S)^q), at most 10⁴. Contrast that both pictures share
/// masks their difference.
#[inline(always)]
pub(crate) fn log_difference(reference: f32, test: f32, log_sensitivity: f32, masking: f32) -> f32 {
    let differs = (test - reference).abs();
    let common = test.abs().min(reference.abs());
    let seen = log2(differs.max(TINY)) + log_sensitivity;
    let mask = log2(common.max(TINY)) + log_sensitivity + MASK_GAIN;
    let found = (DIFFERENCE * seen - log2(1.0 + exp2(masking * mask))).min(MOST);
    if differs > 0.0 { found } else { f32::MIN }
}

/// 2^(`power` · `log`); 0 for `f32::MIN`.
#[inline(always)]
pub(crate) fn power(log: f32, power: f32) -> f32 {
    let found = exp2(power * log);
    if log > f32::MIN { found } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn formula(r: f64, t: f64, s: f64, q: f64) -> f64 {
        let mask = 10_f64.powf(-0.973838) * r.abs().min(t.abs()) * s;
        (((t - r).abs() * s).powf(2.4) / (1.0 + mask.powf(q))).min(1e4)
    }

    #[test]
    fn logarithms_give_what_the_formula_gives() {
        let contrasts = [-1.7, -0.3, -1e-3, 0.0, 1e-5, 0.02, 0.4, 3.0, 900.0];
        for (r, t) in contrasts.into_iter().flat_map(|r| contrasts.map(|t| (r, t))) {
            for (s, q) in [(0.5, 0), (6.0, 1), (150.0, 0), (700.0, 1)] {
                let log = log_difference(r, t, f32::log2(s), MASKING[q]);
                let found = f64::from(power(log, 1.0));
                let expected = formula(r.into(), t.into(), s.into(), MASKING[q].into());
                assert!((found - expected).abs() <= 2e-5 * expected, "{r} {t} {s}: {found} {expected}");
            }
        }
        assert_eq!(power(log_difference(0.3, 0.3, 5.0, MASKING[0]), 1.5), 0.0);
    }
}
