//! The weights that training starts from.

use crate::Result;
use fovol_net::plan::{NetworkConfig, Parameter};
use fovol_net::weights::Array;
use fovol_net::{Error, Weights};

/// Seeded random weights to train from: the same seed and configuration, the same weights on any machine.
///
/// Convolutions have what PyTorch gives them, Kaiming-uniform with a = √5, which is ±1/√fan-in; the last one, which
/// makes the picture, is Xavier-uniform, ±√(6 / (fan-in + fan-out)); biases are zero (ALGORITHMS §1.2). Normalisations
/// begin as identities.
///
/// # Errors
/// A configuration that makes no network.
pub fn initial_weights(config: &NetworkConfig, seed: u64) -> Result<Weights> {
    let plan = config.plan().map_err(Error::Config)?;
    let arrays = plan.parameters().into_iter().map(|parameter| {
        let values = values(&parameter, seed);
        (parameter.name, Array { shape: parameter.shape, values })
    });
    Ok(Weights::new(config.clone(), arrays.collect()))
}

fn values(parameter: &Parameter, seed: u64) -> Vec<f32> {
    let is_weight = parameter.name.ends_with(".weight");
    if parameter.shape.len() == 1 {
        return vec![if is_weight { 1.0 } else { 0.0 }; parameter.len()];
    }
    let inputs: usize = parameter.shape[1..].iter().product();
    let outputs = parameter.len() / parameter.shape[1];
    let reach = match parameter.name.as_str() {
        "output.weight" => (6.0 / (inputs + outputs) as f64).sqrt(),
        _ => 1.0 / (inputs as f64).sqrt(),
    };
    let mut random = SplitMix64::new(&parameter.name, seed);
    (0..parameter.len()).map(|_| (reach * (2.0 * random.unit() - 1.0)) as f32).collect()
}

/// SplitMix64 (Steele, Lea and Flood 2014).
struct SplitMix64 {
    state: u64,
}

impl SplitMix64 {
    /// A stream of its own for each `name` and `seed`.
    fn new(name: &str, seed: u64) -> Self {
        let mut stream = Self { state: seed };
        for byte in name.bytes() {
            stream.state = stream.next() ^ u64::from(byte);
        }
        stream
    }

    fn next(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.state ^ (self.state >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// A number of 53 random bits in 0…1, 1 excluded.
    fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovol_net::plan::Named;

    #[test]
    fn weights_fill_their_range_and_follow_name_and_seed() {
        let config = Named::WNetPaper.config();
        let weights = initial_weights(&config, 3).unwrap();
        weights.check(&config.plan().unwrap()).unwrap();
        let of = |weights: &Weights, name: &str| weights.values(name).unwrap().to_vec();
        let first = of(&weights, "encoder.1.conv1.weight");
        let reach = 1.0 / (64.0f32 * 9.0).sqrt();
        let most = first.iter().fold(0.0f32, |most, w| most.max(w.abs()));
        assert!(most <= reach && most > 0.999 * reach);
        // A uniform distribution of this reach has a third of the reach's square as variance.
        let variance = first.iter().map(|w| w * w).sum::<f32>() / first.len() as f32;
        assert!((variance / (reach * reach / 3.0) - 1.0).abs() < 0.02, "{variance}");
        assert!(of(&weights, "encoder.1.conv1.bias").iter().all(|&b| b == 0.0));
        let last = of(&weights, "output.weight").iter().fold(0.0f32, |most, w| most.max(w.abs()));
        assert!(last <= (6.0f32 / 67.0).sqrt() && last > 0.9 * (6.0f32 / 67.0).sqrt());
        assert_ne!(first, of(&weights, "encoder.1.conv2.weight"));
        assert_ne!(first, of(&initial_weights(&config, 4).unwrap(), "encoder.1.conv1.weight"));
        assert_eq!(weights, initial_weights(&config, 3).unwrap());
        let norms = initial_weights(&Named::DeepFoveaOrig.config(), 3).unwrap();
        assert!(of(&norms, "decoder.0.norm.weight").iter().all(|&w| w == 1.0));
    }
}
