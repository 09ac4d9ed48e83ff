//! Random weights that depend only on seed and parameter names, so that they are equal on all machines.

use crate::plan::Parameter;

/// Increment of the generator: 2⁶⁴ divided by the golden ratio.
const GOLDEN: u64 = 0x9E37_79B9_7F4A_7C15;

/// Random values of `parameter` for `seed`.
///
/// Number *i* is u = (mix(k + (i+1)·GOLDEN) >> 40) / 2²⁴ with k = FNV-1a(name) ⊕ seed·GOLDEN and SplitMix64's mix.
/// A weight is (2u − 1)·√(5/fan-in), a bias 0.05·(2u − 1), and a factor of a normalisation 1 + 0.1·(2u − 1). All is
/// computed in f64 and then rounded.
pub fn values(parameter: &Parameter, seed: u64) -> Vec<f32> {
    let key = fnv1a(&parameter.name) ^ seed.wrapping_mul(GOLDEN);
    let fan_in: usize = parameter.shape[1..].iter().product();
    let (middle, reach) = match (parameter.shape.len(), parameter.name.ends_with(".weight")) {
        (1, true) => (1.0, 0.1),
        (1, false) => (0.0, 0.05),
        _ => (0.0, (5.0 / fan_in as f64).sqrt()),
    };
    (0..parameter.len() as u64)
        .map(|i| {
            let bits = mix(key.wrapping_add((i + 1).wrapping_mul(GOLDEN))) >> 40;
            let u = bits as f64 / f64::from(1u32 << 24);
            (middle + (2.0 * u - 1.0) * reach) as f32
        })
        .collect()
}

fn fnv1a(text: &str) -> u64 {
    text.bytes().fold(0xCBF2_9CE4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01B3)
    })
}

fn mix(z: u64) -> u64 {
    let z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_fill_their_range_and_follow_name_and_seed() {
        let parameter = |name: &str, shape: &[usize]| Parameter { name: name.into(), shape: shape.into() };
        let weights = values(&parameter("a.weight", &[64, 20, 3, 3]), 1);
        let reach = (5.0f32 / 180.0).sqrt();
        let (low, high) = weights.iter().fold((0.0f32, 0.0f32), |(l, h), &w| (l.min(w), h.max(w)));
        assert!(low >= -reach && high <= reach && low < -0.99 * reach && high > 0.99 * reach);
        let mean: f32 = weights.iter().sum::<f32>() / weights.len() as f32;
        assert!(mean.abs() < 0.01 * reach, "{mean}");
        assert_ne!(weights, values(&parameter("a.weight", &[64, 20, 3, 3]), 2));
        assert_ne!(weights, values(&parameter("b.weight", &[64, 20, 3, 3]), 1));
        assert!(values(&parameter("n.weight", &[9]), 0).iter().all(|w| (w - 1.0).abs() <= 0.1));
        assert!(values(&parameter("n.bias", &[9]), 0).iter().all(|w| w.abs() <= 0.05));
    }
}
