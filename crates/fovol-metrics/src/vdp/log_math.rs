//! Logarithm and power functions that compilers vectorise. The metric needs several per pixel, and the library's are
//! calls.

use std::f32::consts::{LN_2, LOG2_E};

/// log₂ of a positive normal number, with an error of about 2e-7.
///
/// The mantissa m in [2/3, 4/3) enters the power series of ln m = 2 artanh((m − 1)/(m + 1)).
#[inline(always)]
pub(crate) fn log2(x: f32) -> f32 {
    const TWO_THIRDS: u32 = 0x3f2a_aaab;
    let offset = x.to_bits().wrapping_sub(TWO_THIRDS) & 0xff80_0000;
    let mantissa = f32::from_bits(x.to_bits().wrapping_sub(offset));
    let exponent = ((offset as i32) >> 23) as f32;
    let s = (mantissa - 1.0) / (mantissa + 1.0);
    let q = s * s;
    let series = 1.0 + q * (1.0 / 3.0 + q * (1.0 / 5.0 + q * (1.0 / 7.0 + q * (1.0 / 9.0))));
    exponent + s * series * (2.0 * LOG2_E)
}

/// 2ˣ with a relative error of about 2e-7; x is clamped to ±126.
///
/// The integer part goes to the exponent, the rest to the power series of e to the x ln 2.
#[inline(always)]
pub(crate) fn exp2(x: f32) -> f32 {
    // Adding this to a small number leaves the nearest integer in the lowest bits of the mantissa.
    const ROUND: f32 = 12_582_912.0;
    let x = x.clamp(-126.0, 126.0);
    let shifted = x + ROUND;
    let t = (x - (shifted - ROUND)) * LN_2;
    let high = t * (1.0 / 24.0 + t * (1.0 / 120.0 + t * (1.0 / 720.0 + t * (1.0 / 5040.0))));
    let series = 1.0 + t * (1.0 + t * (0.5 + t * (1.0 / 6.0 + high)));
    let power = (shifted.to_bits() << 23).wrapping_add(1.0_f32.to_bits());
    series * f32::from_bits(power)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_agree_with_the_library_over_the_whole_range() {
        for i in 0..20_000 {
            let x = (i as f32 - 10_000.0) * 0.0125;
            let power = exp2(x);
            let expected = f64::from(x).exp2();
            assert!((f64::from(power) / expected - 1.0).abs() < 4e-7, "2^{x}");
            let back = f64::from(log2(power)) - f64::from(power).log2();
            assert!(back.abs() < 3e-7 * f64::from(x.abs().max(1.0)), "log2 of {power}: {back}");
        }
        assert_eq!((log2(1.0), exp2(0.0)), (0.0, 1.0));
        assert!(exp2(-1e9) < 1e-37 && exp2(1e9).is_finite());
    }
}
