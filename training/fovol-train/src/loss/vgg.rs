//! Convolutions of VGG-16 and VGG-19 (Simonyan and Zisserman 2014), with torchvision's names.

use crate::{Error, Result};
use std::collections::BTreeMap;
use std::path::Path;
use tch::{Device, Kind, Tensor};

/// Number of stages of both networks. Each stage after the first begins with a 2×2 max pooling.
pub const STAGES: usize = 5;
/// Channels of each stage.
const WIDTHS: [i64; STAGES] = [64, 128, 256, 512, 512];
/// Smallest side of a picture in pixels; four poolings leave one pixel.
const SMALLEST: i64 = 16;

/// Choice between VGG-16 and VGG-19.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Depth {
    /// 13 convolutions.
    Vgg16,
    /// 16 convolutions.
    Vgg19,
}

impl Depth {
    /// Name of the network.
    pub fn name(self) -> &'static str {
        match self {
            Self::Vgg16 => "VGG-16",
            Self::Vgg19 => "VGG-19",
        }
    }

    /// Name of torchvision's weights file; it ends with the first digits of the file's SHA-256.
    pub fn original_file(self) -> &'static str {
        match self {
            Self::Vgg16 => "vgg16-397923af.pth",
            Self::Vgg19 => "vgg19-dcbb9e9d.pth",
        }
    }

    /// Indices i of the convolutions `features.{i}`, per stage. ReLUs and poolings are counted too.
    pub fn convolutions(self) -> [Vec<usize>; STAGES] {
        let counts = match self {
            Self::Vgg16 => [2, 2, 3, 3, 3],
            Self::Vgg19 => [2, 2, 4, 4, 4],
        };
        let mut next = 0;
        counts.map(|count| {
            let stage = (0..count).map(|k| next + 2 * k).collect();
            next += 2 * count + 1;
            stage
        })
    }
}

/// Place in each stage where features are taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tap {
    /// Output of the last convolution, before its ReLU.
    Last,
    /// Output of the last ReLU.
    LastRelu,
    /// Output of the second ReLU.
    SecondRelu,
}

/// One convolution.
#[derive(Debug)]
struct Conv {
    weight: Tensor,
    bias: Tensor,
}

impl Conv {
    fn of(&self, input: &Tensor) -> Tensor {
        let kind = input.kind();
        input.conv2d(&self.weight.to_kind(kind), Some(&self.bias.to_kind(kind)), 1, 1, 1, 1)
    }
}

/// VGG network with fixed weights.
#[derive(Debug)]
pub struct Vgg {
    stages: [Vec<Conv>; STAGES],
}

impl Vgg {
    /// Builds the network of `depth` from `tensors`: `features.{i}.weight` \[out, in, 3, 3\] and `features.{i}.bias`
    /// \[out\]. Any channel counts are accepted.
    ///
    /// # Errors
    /// Weights that are missing or do not fit each other.
    pub fn new(depth: Depth, tensors: &BTreeMap<String, Tensor>, device: Device) -> Result<Self> {
        let mut channels = 3;
        let mut stages: [Vec<Conv>; STAGES] = Default::default();
        for (stage, numbers) in stages.iter_mut().zip(depth.convolutions()) {
            for number in numbers {
                let [weight, bias] = ["weight", "bias"].map(|part| {
                    let name = format!("features.{number}.{part}");
                    let missing = || wrong(depth, &format!("`{name}` is missing"));
                    tensors.get(&name).ok_or_else(missing)
                });
                let (weight, bias) = (weight?, bias?);
                let (shape, out) = (weight.size(), bias.numel() as i64);
                if shape != [out, channels, 3, 3] || out == 0 {
                    let problem =
                        format!("`features.{number}.weight` is {shape:?}, not [{out}, {channels}, 3, 3]");
                    return Err(wrong(depth, &problem));
                }
                let frozen = |tensor: &Tensor| tensor.detach().to_kind(Kind::Float).to_device(device);
                stage.push(Conv { weight: frozen(weight), bias: frozen(&bias.view([-1])) });
                channels = out;
            }
        }
        Ok(Self { stages })
    }

    /// Builds the network of `depth` with random weights from `seed` and zero biases.
    ///
    /// Weights are uniform in ±√(6 / fan-in), which preserves the magnitude of features from layer to layer: He et
    /// al., "Delving deep into rectifiers" (2015).
    pub fn random(depth: Depth, seed: u64, device: Device) -> Self {
        let mut channels = 3;
        let mut stages: [Vec<Conv>; STAGES] = Default::default();
        let numbers = depth.convolutions();
        for ((stage, numbers), out) in stages.iter_mut().zip(numbers).zip(WIDTHS) {
            for number in numbers {
                let fan_in = channels * 9;
                let reach = (6.0 / fan_in as f64).sqrt();
                let values = uniform(seed, number as u64, (out * fan_in) as usize, reach);
                let weight = Tensor::from_slice(&values).view([out, channels, 3, 3]).to_device(device);
                stage.push(Conv { weight, bias: Tensor::zeros([out], (Kind::Float, device)) });
                channels = out;
            }
        }
        Self { stages }
    }

    /// Number of feature channels of each stage.
    pub fn channels(&self) -> [i64; STAGES] {
        self.stages.each_ref().map(|stage| stage.last().map_or(0, |conv| conv.weight.size()[0]))
    }

    /// Features of `pictures` \[N, 3, H, W\]: \[N, channels, H/2ˢ, W/2ˢ\] for stage s from 0 on, in the kind of the
    /// pictures.
    ///
    /// # Errors
    /// Pictures with a side below 16 pixels.
    pub fn features(&self, pictures: &Tensor, tap: Tap) -> Result<Vec<Tensor>> {
        let size = pictures.size();
        if size.len() != 4 || size[2].min(size[3]) < SMALLEST {
            return Err(Error::Input(format!(
                "VGG cannot look at pictures of {size:?}; give [batch, 3, rows, columns] with at least {SMALLEST} \
                 rows and columns"
            )));
        }
        let mut features = Vec::with_capacity(STAGES);
        let mut map = pictures.shallow_clone();
        for (s, stage) in self.stages.iter().enumerate() {
            if s > 0 {
                map = map.max_pool2d([2, 2], [2, 2], [0, 0], [1, 1], false);
            }
            let tapped = if tap == Tap::SecondRelu { 1 } else { stage.len() - 1 };
            for (i, conv) in stage.iter().enumerate() {
                let linear = conv.of(&map);
                map = linear.relu();
                if i == tapped {
                    features.push(if tap == Tap::Last { linear } else { map.shallow_clone() });
                    if s + 1 == STAGES {
                        // Layers after the last tap are not computed.
                        return Ok(features);
                    }
                }
            }
        }
        Ok(features)
    }
}

/// Reads the tensors of a safetensors file by name.
///
/// # Errors
/// A file that is missing or damaged.
pub fn read_tensors(path: &Path, depth: Depth) -> Result<BTreeMap<String, Tensor>> {
    let tensors = Tensor::read_safetensors(path).map_err(|problem| {
        let problem = problem.to_string();
        let line = problem.lines().next().unwrap_or_default();
        Error::Input(format!(
            "the weights of {} cannot be read from {}: {line}; make that file with `fovolnet-train convert-vgg {} {}`",
            depth.name(),
            path.display(),
            depth.original_file(),
            path.display()
        ))
    })?;
    Ok(tensors.into_iter().collect())
}

/// Error for weights that are not those of `depth`.
pub(super) fn wrong(depth: Depth, problem: &str) -> Error {
    let mend = format!("convert torchvision's {} with `fovolnet-train convert-vgg`", depth.original_file());
    Error::Input(format!("these are no weights of {}: {problem}; {mend}", depth.name()))
}

/// `count` uniform values in ±`reach` from `seed` and `stream`, by SplitMix64.
fn uniform(seed: u64, stream: u64, count: usize, reach: f64) -> Vec<f32> {
    const GOLDEN: u64 = 0x9E37_79B9_7F4A_7C15;
    let mix = |z: u64| {
        let z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    };
    let key = mix(mix(seed.wrapping_add(GOLDEN)).wrapping_add(stream.wrapping_mul(GOLDEN)));
    (1..=count as u64)
        .map(|i| {
            let u = (mix(key.wrapping_add(i.wrapping_mul(GOLDEN))) >> 40) as f64 / f64::from(1u32 << 24);
            ((2.0 * u - 1.0) * reach) as f32
        })
        .collect()
}
