//! Initial weights for training.

use crate::Result;
use fovol_net::plan::{Activation, Blend, Layer, NetworkConfig, Parameter, Plan, Read};
use fovol_net::weights::Array;
use fovol_net::{Error, Weights};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

/// Initial range of the weights of convolutions with a rectifier.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Spread {
    /// PyTorch's default and the paper's choice: Kaiming-uniform with a = √5, ±1/√fan-in. Every layer shrinks signals
    /// to about 0.4 of their size, so deep levels learn late or never.
    #[default]
    Pytorch,
    /// He et al. (2015): ±√(6/fan-in). Signals keep their size through rectifiers.
    He,
    /// [`Spread::He`], with the channels of every layer assigned to red, green and blue in turn and small weights
    /// between colours. Without this, deep networks with direct prediction first learn grey pictures and stay there
    /// for thousands of steps.
    HeByColour,
}

/// Random initial weights that depend on `seed` and configuration only, on any machine.
///
/// Convolutions are uniform in ±1/√fan-in; convolutions with a rectifier follow `spread`. The last layer of the
/// direct prediction is Xavier-uniform, ±√(6 / (fan-in + fan-out)). Biases are zero
/// (docs/guide/src/internals/algorithm.md, section 4.1). Normalisations begin as identities.
///
/// Networks with a filled picture begin as that fill. Kernels put most of their weight on the filled pixel, direct
/// predictions that read the fill reproduce it, and the picture added to the kernels' result is zero.
///
/// # Errors
/// A configuration that makes no network.
pub fn initial_weights(config: &NetworkConfig, spread: Spread, seed: u64) -> Result<Weights> {
    let plan = config.plan().map_err(Error::Config)?;
    let wide = if spread == Spread::Pytorch { BTreeSet::new() } else { rectified(&plan) };
    let arrays = plan.parameters().into_iter().map(|parameter| {
        let values = values(&parameter, wide.contains(parameter.name.as_str()), seed);
        (parameter.name, Array { shape: parameter.shape, values })
    });
    let mut arrays: BTreeMap<String, Array> = arrays.collect();
    if spread == Spread::HeByColour {
        keep_colours_apart(&plan, &mut arrays);
    }
    for (name, taps) in taps_of_fillings(&plan) {
        let [bias, weight] = ["bias", "weight"].map(|part| format!("{name}.{part}"));
        if let Some(bias) = arrays.get_mut(&bias) {
            bias.values.fill(OTHER_TAPS);
            taps.into_iter().for_each(|channels| bias.values[channels].fill(FILLING_TAP));
        }
        if let Some(weight) = arrays.get_mut(&weight) {
            weight.values.iter_mut().for_each(|w| *w *= FEATURES);
        }
    }
    if let (Some(weight), Some(reads)) = (arrays.get_mut("output.weight"), reads_filling(&plan)) {
        begin_as_filling(weight, reads);
    }
    Ok(Weights::new(config.clone(), arrays))
}

/// Initial kernel values of the filled pixel and of all other taps. Kernels are squared, and a square has no gradient
/// at 0; so the other taps begin small instead.
const FILLING_TAP: f32 = 0.5;
const OTHER_TAPS: f32 = 0.05;

/// Factors of weights between channels of one colour and of different colours. The sum of squares stays about the
/// same.
const OF_ONE_COLOUR: f32 = 1.7;
const OF_OTHERS: f32 = 0.25;

/// Makes weights between channels of different colours small. The output layer gets positive weights from each colour
/// to itself.
fn keep_colours_apart(plan: &Plan, arrays: &mut BTreeMap<String, Array>) {
    for layer in plan.layers() {
        let Layer::Conv(conv) = layer else { continue };
        let Some(weight) = arrays.get_mut(&format!("{}.weight", conv.name)) else { continue };
        let channels = conv.inputs.iter().map(|read| plan.tensor(read.tensor).channels);
        let colours: Vec<usize> = channels.flat_map(|count| (0..count).map(|c| c % 3)).collect();
        let of_picture = conv.name == "output";
        let window = conv.size * conv.size;
        for (output, weights) in weight.values.chunks_exact_mut(colours.len() * window).enumerate() {
            for (weights, colour) in weights.chunks_exact_mut(window).zip(&colours) {
                let is_own = *colour == output % 3;
                for w in weights {
                    *w = match (of_picture, is_own) {
                        (false, own) => *w * if own { OF_ONE_COLOUR } else { OF_OTHERS },
                        (true, true) => 0.6 * w.abs(),
                        (true, false) => 0.05 * *w,
                    };
                }
            }
        }
    }
}

/// Names of the weights of convolutions with a rectifier.
fn rectified(plan: &Plan) -> BTreeSet<String> {
    let name = |layer: &Layer| match layer {
        Layer::Conv(conv) if conv.activation != Activation::None => Some(format!("{}.weight", conv.name)),
        _ => None,
    };
    plan.layers().iter().filter_map(name).collect()
}

/// Kernel-predicting layers that filter filled pictures, with their output channels of the filled pixel itself.
fn taps_of_fillings(plan: &Plan) -> Vec<(String, Vec<Range<usize>>)> {
    let is_filling =
        |id| plan.layers().iter().any(|l| matches!(l, Layer::Blend(Blend { output, .. }) if *output == id));
    let mut found = Vec::new();
    for layer in plan.layers() {
        let Layer::Filter(filter) = layer else { continue };
        let pixels = filter.expand * filter.expand;
        let (mut before, mut fillings) = (0, Vec::new());
        for (read, taps) in &filter.images {
            let centre = before + taps.count() / 2;
            if is_filling(read.tensor) {
                fillings.push(pixels * centre..pixels * (centre + 1));
            }
            before += taps.count();
        }
        if !fillings.is_empty() {
            found.push((filter.name.clone(), fillings));
        }
    }
    found
}

/// Input channels of the output layer that hold the filled picture, if it reads that.
fn reads_filling(plan: &Plan) -> Option<Range<usize>> {
    let of_output = |layer: &Layer| match layer {
        Layer::Conv(conv) if conv.name == "output" && conv.inputs.len() == 2 => Some(conv.inputs.clone()),
        _ => None,
    };
    let [features, filled] = plan.layers().iter().find_map(of_output)?[..] else { return None };
    let channels = |read: Read| plan.tensor(read.tensor).channels;
    Some(channels(features)..channels(features) + channels(filled))
}

/// Initial factor of the feature weights beside a filled picture. Untrained features are noise, and a large factor
/// would drive their rectifiers to zero for good.
const FEATURES: f32 = 0.1;

/// Makes the output layer copy the filled picture at the inputs `filled`, plus a little of the features.
fn begin_as_filling(weight: &mut Array, filled: Range<usize>) {
    for (output, weights) in weight.values.chunks_exact_mut(filled.end).enumerate() {
        weights[..filled.start].iter_mut().for_each(|w| *w *= FEATURES);
        for (channel, w) in weights[filled.clone()].iter_mut().enumerate() {
            *w = f32::from(u8::from(channel == output));
        }
    }
}

fn values(parameter: &Parameter, wide: bool, seed: u64) -> Vec<f32> {
    let is_weight = parameter.name.ends_with(".weight");
    if parameter.shape.len() == 1 {
        return vec![if is_weight { 1.0 } else { 0.0 }; parameter.len()];
    }
    let inputs: usize = parameter.shape[1..].iter().product();
    let outputs = parameter.len() / parameter.shape[1];
    if parameter.name == "addition.weight" {
        return vec![0.0; parameter.len()];
    }
    let reach = match parameter.name.as_str() {
        "output.weight" => (6.0 / (inputs + outputs) as f64).sqrt(),
        _ if wide => (6.0 / inputs as f64).sqrt(),
        _ => 1.0 / (inputs as f64).sqrt(),
    };
    let mut random = SplitMix64::new(&parameter.name, seed);
    (0..parameter.len()).map(|_| (reach * (2.0 * random.unit() - 1.0)) as f32).collect()
}

/// Random generator SplitMix64 (Steele, Lea and Flood 2014).
struct SplitMix64 {
    state: u64,
}

impl SplitMix64 {
    /// Creates an independent stream for each `name` and `seed`.
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

    /// Uniform random number in 0…1 with 53 bits, 1 excluded.
    fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovol_net::plan::Named;

    #[test]
    fn networks_that_weigh_a_filling_begin_as_it() {
        use crate::network::{Inputs, Network, Options};
        use tch::{Device, Kind, Tensor};
        let weights = initial_weights(&Named::WNetFast.config(), Spread::Pytorch, 1).unwrap();
        let network = Network::new(&weights, Options::default(), Device::Cpu).unwrap();
        // Input: every second pixel of a smooth picture.
        let picture = Tensor::linspace(0.2, 0.8, 32, (Kind::Float, Device::Cpu))
            .view([1, 1, 1, 32])
            .repeat([1, 3, 32, 1]);
        let mask = Tensor::from_slice(&[1.0f32, 0.0]).repeat([16]).view([1, 1, 1, 32]).repeat([1, 1, 32, 1]);
        let inputs = Inputs { colour: &(&picture * &mask), mask: Some(&mask), motion: None };
        let (output, _) = network.forward(&inputs, network.initial_state([1, 32, 32])).unwrap();
        let away = (output - picture).abs().mean(Kind::Float).double_value(&[]);
        assert!(away < 0.06, "{away}");
    }

    #[test]
    fn weights_fill_their_range_and_follow_name_and_seed() {
        let config = Named::WNetPaper.config();
        let weights = initial_weights(&config, Spread::Pytorch, 3).unwrap();
        weights.check(&config.plan().unwrap()).unwrap();
        let of = |weights: &Weights, name: &str| weights.values(name).unwrap().to_vec();
        let first = of(&weights, "encoder.1.conv1.weight");
        let reach = 1.0 / (64.0f32 * 9.0).sqrt();
        let most = first.iter().fold(0.0f32, |most, w| most.max(w.abs()));
        assert!(most <= reach && most > 0.999 * reach);
        // A uniform distribution in ±r has the variance r²/3.
        let variance = first.iter().map(|w| w * w).sum::<f32>() / first.len() as f32;
        assert!((variance / (reach * reach / 3.0) - 1.0).abs() < 0.02, "{variance}");
        assert!(of(&weights, "encoder.1.conv1.bias").iter().all(|&b| b == 0.0));
        let last = of(&weights, "output.weight").iter().fold(0.0f32, |most, w| most.max(w.abs()));
        assert!(last <= (6.0f32 / 67.0).sqrt() && last > 0.9 * (6.0f32 / 67.0).sqrt());
        assert_ne!(first, of(&weights, "encoder.1.conv2.weight"));
        assert_ne!(
            first,
            of(&initial_weights(&config, Spread::Pytorch, 4).unwrap(), "encoder.1.conv1.weight")
        );
        assert_eq!(weights, initial_weights(&config, Spread::Pytorch, 3).unwrap());
        let norms = initial_weights(&Named::DeepFoveaOrig.config(), Spread::Pytorch, 3).unwrap();
        assert!(of(&norms, "decoder.0.norm.weight").iter().all(|&w| w == 1.0));
    }

    #[test]
    fn he_widens_what_a_rectifier_follows_and_nothing_else() {
        let config = Named::WNetPaper.config();
        let narrow = initial_weights(&config, Spread::Pytorch, 3).unwrap();
        let wide = initial_weights(&config, Spread::He, 3).unwrap();
        // Equal draws, scaled by √6.
        let of = |weights: &Weights, name: &str| weights.values(name).unwrap().to_vec();
        for (n, w) in of(&narrow, "encoder.1.conv1.weight").iter().zip(of(&wide, "encoder.1.conv1.weight")) {
            assert!((n * 6.0f32.sqrt() - w).abs() < 1e-6);
        }
        for name in ["output.weight", "encoder.1.conv1.bias"] {
            assert_eq!(of(&narrow, name), of(&wide, name));
        }
    }

    #[test]
    fn colours_go_their_own_ways() {
        let config = Named::DeepFoveaFvn.config();
        let he = initial_weights(&config, Spread::He, 3).unwrap();
        let apart = initial_weights(&config, Spread::HeByColour, 3).unwrap();
        let of = |weights: &Weights, name: &str| weights.values(name).unwrap().to_vec();
        let (before, after) = (of(&he, "encoder.1.conv1.weight"), of(&apart, "encoder.1.conv1.weight"));
        // Output 4 is green, and so are inputs 1, 4, 7 and so on.
        for input in 0..32 {
            let at = (4 * 32 + input) * 9;
            let factor = if input % 3 == 1 { OF_ONE_COLOUR } else { OF_OTHERS };
            assert!((after[at] - factor * before[at]).abs() < 1e-6);
        }
        let squares = |values: &[f32]| values.iter().map(|v| v * v).sum::<f32>();
        assert!((squares(&after) / squares(&before) - 1.0).abs() < 0.05);
        let picture = of(&apart, "output.weight");
        assert!((0..3).all(|c| (c..32).step_by(3).all(|input| picture[32 * c + input] >= 0.0)));
    }
}
