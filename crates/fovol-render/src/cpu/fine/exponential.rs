//! The exponential function in lanes.

use fovol_simd::{SimdF32, SimdI32};

/// ln(2)^k / k! for k = 6 down to 0: the series of 2^f, to 2e-7 for |f| ≤ ½.
const SERIES: [f32; 7] =
    [1.540_353e-4, 1.333_355_8e-3, 9.618_129e-3, 5.550_411e-2, 0.240_226_5, std::f32::consts::LN_2, 1.0];
/// Exponents of 2 are clamped to this magnitude; no optical depth comes near it.
const MOST: f32 = 120.0;
/// 1.5·2²³. Adding it to an f32 rounds to a whole number, held in the lowest bits.
const ROUNDING: f32 = 12_582_912.0;

/// e^(−x).
#[inline(always)]
pub fn passing<V: SimdF32>(x: V) -> V {
    let power = x * x.splat(-std::f32::consts::LOG2_E);
    let power = power.min(x.splat(MOST)).max(x.splat(-MOST));
    let rounded = power + x.splat(ROUNDING);
    let part = power - (rounded - x.splat(ROUNDING));
    let mut value = x.splat(SERIES[0]);
    let mut i = 1;
    while i < SERIES.len() {
        value = value.mul_add(part, x.splat(SERIES[i]));
        i += 1;
    }
    let exponent = (rounded.to_bits() + x.splat_i32(127)).shl_lanes(x.splat_i32(23));
    value * V::from_bits(exponent)
}

/// The mean of e^(−x·s) over s from 0 to 1: (1 − e^(−x))/x.
#[inline(always)]
pub fn mean_passing<V: SimdF32>(x: V) -> V {
    let one = x.splat(1.0);
    let small = x.abs().simd_lt(x.splat(0.05));
    let series = x.mul_add(x.splat(-1.0 / 24.0), x.splat(1.0 / 6.0));
    let series = one - x * (x.splat(0.5) - x * series);
    let divisor = V::select(small, one, x);
    V::select(small, series, (one - passing(x)) / divisor)
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovol_simd::{Arithmetic, Portable};

    #[test]
    fn both_are_the_functions_to_f32() {
        for i in -80..800 {
            let x = i as f32 * 0.1 + 0.003;
            let vector = Portable::zero().splat(x);
            let [one, mean] = [passing(vector), mean_passing(vector)].map(|v| {
                let mut lanes = [0.0; Portable::N];
                v.store(&mut lanes);
                lanes[0]
            });
            let exact = (-f64::from(x)).exp();
            assert!((f64::from(one) / exact - 1.0).abs() < 2e-5, "{x}: {one}");
            let exact = -(-f64::from(x)).exp_m1() / f64::from(x);
            assert!((f64::from(mean) / exact - 1.0).abs() < 2e-5, "{x}: {mean}");
        }
    }
}
