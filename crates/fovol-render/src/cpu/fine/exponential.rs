//! The exponential function in lanes.

use super::super::lanes::Lanes;

/// ln(2)^k / k! for k = 6 down to 0: the series of 2^f, to 2e-7 for |f| ≤ ½.
const SERIES: [f32; 7] =
    [1.540_353e-4, 1.333_355_8e-3, 9.618_129e-3, 5.550_411e-2, 0.240_226_5, std::f32::consts::LN_2, 1.0];
/// Exponents of 2 are clamped to this magnitude; no optical depth comes near it.
const MOST: f32 = 120.0;
/// 1.5·2²³. Adding it to an f32 rounds to a whole number, held in the lowest bits.
const ROUNDING: f32 = 12_582_912.0;

/// e^(−x).
///
/// # Safety
/// The instruction set of `L` must be available.
#[inline(always)]
pub unsafe fn passing<L: Lanes>(x: L::F) -> L::F {
    // SAFETY: the caller's.
    unsafe {
        let power = L::mul(x, L::splat(-std::f32::consts::LOG2_E));
        let power = L::max(L::min(power, L::splat(MOST)), L::splat(-MOST));
        let rounded = L::add(power, L::splat(ROUNDING));
        let part = L::sub(power, L::sub(rounded, L::splat(ROUNDING)));
        let mut value = L::splat(SERIES[0]);
        let mut i = 1;
        while i < SERIES.len() {
            value = L::fma(value, part, L::splat(SERIES[i]));
            i += 1;
        }
        let exponent = L::shift_left(L::add_i(L::to_bits(rounded), L::splat_i(127)), L::splat_i(23));
        L::mul(value, L::from_bits(exponent))
    }
}

/// The mean of e^(−x·s) over s from 0 to 1: (1 − e^(−x))/x.
///
/// # Safety
/// The instruction set of `L` must be available.
#[inline(always)]
pub unsafe fn mean_passing<L: Lanes>(x: L::F) -> L::F {
    // SAFETY: the caller's.
    unsafe {
        let one = L::splat(1.0);
        let small = L::lt(L::abs(x), L::splat(0.05));
        let series = L::fma(x, L::splat(-1.0 / 24.0), L::splat(1.0 / 6.0));
        let series = L::sub(one, L::mul(x, L::sub(L::splat(0.5), L::mul(x, series))));
        let divisor = L::select(small, one, x);
        L::select(small, series, L::div(L::sub(one, passing::<L>(x)), divisor))
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::lanes::portable::Portable;
    use super::*;

    #[test]
    fn both_are_the_functions_to_f32() {
        for i in -80..800 {
            let x = i as f32 * 0.1 + 0.003;
            // SAFETY: portable lanes need nothing.
            let (one, mean) =
                unsafe { (passing::<Portable>([x; 8])[0], mean_passing::<Portable>([x; 8])[0]) };
            let exact = (-f64::from(x)).exp();
            assert!((f64::from(one) / exact - 1.0).abs() < 2e-5, "{x}: {one}");
            let exact = -(-f64::from(x)).exp_m1() / f64::from(x);
            assert!((f64::from(mean) / exact - 1.0).abs() < 2e-5, "{x}: {mean}");
        }
    }
}
