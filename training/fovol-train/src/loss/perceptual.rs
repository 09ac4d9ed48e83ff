//! Perceptual measures: how different two pictures look.

use super::pictures::{mean, means, picture_shape};
use super::ssim::{ms_ssim, ssim};
use super::vgg::{Depth, STAGES, Tap, Vgg, read_tensors, wrong};
use crate::Result;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use tch::{Device, Kind, Tensor};

/// Stage weights of the measure that FoVolNet was trained with (the authors' code).
const FOVOLNET: [f64; STAGES] = [0.52879148, 0.13693107, 0.05858061, 0.09629559, 0.17940125];
/// Stage weights in DeepFovea's graph.
const DEEPFOVEA: [f64; STAGES] = [1.0 / 16.0, 1.0 / 28.0, 1.0 / 40.0, 1.0 / 100.0, 1.0 / 9.0];
/// Keeps the length of feature vectors above zero in LPIPS.
const LPIPS_EPSILON: f64 = 1e-10;
/// Size of the pictures that calibrate the weights of random features.
const CALIBRATION: [i64; 2] = [64, 64];

/// Differentiable measure of how different two pictures look.
pub trait Perceptual: std::fmt::Debug + Send {
    /// Distance of each picture \[N, 3, H, W\] in 0…1 from its reference: \[N\], 0 for equal pictures.
    ///
    /// # Errors
    /// Pictures of different shapes, or too small for this measure.
    fn distances(&self, output: &Tensor, reference: &Tensor) -> Result<Tensor>;

    /// Mean of [`Self::distances`]: a scalar.
    ///
    /// # Errors
    /// Errors of [`Self::distances`].
    fn distance(&self, output: &Tensor, reference: &Tensor) -> Result<Tensor> {
        Ok(mean(&self.distances(output, reference)?))
    }

    /// Name for tables.
    fn name(&self) -> &'static str;
}

/// Choice of a measure and its parameters.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "measure", rename_all = "kebab-case", deny_unknown_fields)]
pub enum PerceptualConfig {
    /// [`L1MsSsim`], which needs no weights.
    L1MsSsim(L1MsSsim),
    /// [`PlainSsim`], which needs no weights.
    Ssim,
    /// [`VggDistance::fovolnet`], which FoVolNet's authors call LPIPS.
    FovolnetVgg(VggFile),
    /// [`Lpips`] 0.1 with VGG-16. Its file also holds the heads.
    Lpips(VggFile),
    /// [`VggDistance::random`], which needs no weights.
    RandomVgg(RandomVgg),
    /// [`VggDistance::deepfovea`].
    DeepfoveaVgg(VggFile),
}

/// Weights file of a VGG network, provided by the user.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct VggFile {
    /// File made by `fovolnet-train convert-vgg`.
    pub weights: PathBuf,
    /// Whether features are computed in bf16.
    #[serde(default)]
    pub bf16: bool,
}

/// VGG network with random weights.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, rename_all = "kebab-case", deny_unknown_fields)]
pub struct RandomVgg {
    /// Seed of all weights.
    pub seed: u64,
    /// Whether features are computed in bf16.
    pub bf16: bool,
}

impl Default for RandomVgg {
    fn default() -> Self {
        Self { seed: 1, bf16: false }
    }
}

impl Default for PerceptualConfig {
    fn default() -> Self {
        Self::L1MsSsim(L1MsSsim::default())
    }
}

impl PerceptualConfig {
    /// Builds the measure with its weights on `device`.
    ///
    /// # Errors
    /// Files that cannot be read or hold other weights.
    pub fn build(&self, device: Device) -> Result<Box<dyn Perceptual>> {
        let vgg =
            |depth: Depth, file: &VggFile| Vgg::new(depth, &read_tensors(&file.weights, depth)?, device);
        Ok(match self {
            Self::L1MsSsim(measure) => Box::new(*measure),
            Self::Ssim => Box::new(PlainSsim),
            Self::FovolnetVgg(file) => {
                Box::new(VggDistance::fovolnet(vgg(Depth::Vgg19, file)?).with_bf16(file.bf16))
            }
            Self::Lpips(file) => {
                let tensors = read_tensors(&file.weights, Depth::Vgg16)?;
                Box::new(Lpips::new(&tensors, device)?.with_bf16(file.bf16))
            }
            Self::RandomVgg(random) => {
                Box::new(VggDistance::random(random.seed, device)?.with_bf16(random.bf16))
            }
            Self::DeepfoveaVgg(file) => {
                Box::new(VggDistance::deepfovea(vgg(Depth::Vgg19, file)?).with_bf16(file.bf16))
            }
        })
    }
}

/// `structure`·(1 − MS-SSIM) + (1 − `structure`)·L1 + `gradient`·L1 of the gradients.
///
/// The mix follows Zhao et al., "Loss functions for image restoration with neural networks" (2017), and needs no
/// weights. Gradients are the differences to the pixel below and to the right.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, rename_all = "kebab-case", deny_unknown_fields)]
pub struct L1MsSsim {
    /// Fraction of MS-SSIM, 0…1.
    pub structure: f64,
    /// Weight of the gradient term.
    pub gradient: f64,
}

impl Default for L1MsSsim {
    fn default() -> Self {
        Self { structure: 0.84, gradient: 0.25 }
    }
}

impl Perceptual for L1MsSsim {
    fn distances(&self, output: &Tensor, reference: &Tensor) -> Result<Tensor> {
        let structure = 1.0 - ms_ssim(output, reference)?;
        let plain = means(&(output - reference).abs());
        let gradients = gradient_l1(output, reference)?;
        Ok(structure * self.structure + plain * (1.0 - self.structure) + gradients * self.gradient)
    }

    fn name(&self) -> &'static str {
        "L1 + MS-SSIM"
    }
}

/// 1 − SSIM at full resolution. MS-SSIM gives the finest scale little weight; this measure uses it alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PlainSsim;

impl Perceptual for PlainSsim {
    fn distances(&self, output: &Tensor, reference: &Tensor) -> Result<Tensor> {
        Ok(1.0 - ssim(output, reference)?)
    }

    fn name(&self) -> &'static str {
        "SSIM"
    }
}

/// Mean absolute difference between the image gradients of two batches \[N, C, H, W\]: \[N\].
///
/// Gradients are forward differences along rows and columns, where both exist.
///
/// # Errors
/// Pictures of different or invalid shapes.
pub fn gradient_l1(output: &Tensor, reference: &Tensor) -> Result<Tensor> {
    let [_, _, height, width] = picture_shape(output, reference)?;
    // Differences are linear, so the gradient of the error is the error of the gradients.
    let error = output - reference;
    let part = |top: i64, left: i64| error.narrow(2, top, height - 1).narrow(3, left, width - 1);
    let corner = part(0, 0);
    let (down, right) = (part(1, 0) - &corner, part(0, 1) - &corner);
    Ok((means(&down.abs()) + means(&right.abs())) * 0.5)
}

/// Feature distance Σ_s weight_s · mean |f_s(output) − f_s(reference)| over the stages s of a VGG network.
#[derive(Debug)]
pub struct VggDistance {
    vgg: Vgg,
    tap: Tap,
    weights: [f64; STAGES],
    input: Input,
    bf16: bool,
    name: &'static str,
}

impl VggDistance {
    /// The measure that FoVolNet's authors trained with and call LPIPS.
    ///
    /// It compares the last convolution of each stage of VGG-19 before its ReLU, with fixed weights. Features are not
    /// normalised, there are no learned heads, and pictures are not standardised.
    pub fn fovolnet(vgg: Vgg) -> Self {
        Self {
            vgg,
            tap: Tap::Last,
            weights: FOVOLNET,
            input: Input::Plain,
            bf16: false,
            name: "VGG-19 features",
        }
    }

    /// DeepFovea's measure: the second ReLU of each stage of VGG-19, with the weights of its graph.
    ///
    /// The scaling of pictures in that graph is unknown. Here they are standardised as for ImageNet, on which
    /// torchvision's weights were trained.
    pub fn deepfovea(vgg: Vgg) -> Self {
        let name = "VGG-19 features (DeepFovea)";
        Self { vgg, tap: Tap::SecondRelu, weights: DEEPFOVEA, input: Input::ImageNet, bf16: false, name }
    }

    /// [`VggDistance::fovolnet`] with random weights from `seed` (Liu et al., "A generic perceptual loss for modeling
    /// structured output dependencies", 2021).
    ///
    /// Stage weights are calibrated on synthetic pictures and their blurred copies. Each stage contributes equally,
    /// and the sum equals their mean absolute difference.
    ///
    /// # Errors
    /// None that a caller could cause.
    pub fn random(seed: u64, device: Device) -> Result<Self> {
        let vgg = Vgg::random(Depth::Vgg19, seed, device);
        let name = "random VGG-19 features";
        let mut random =
            Self { vgg, tap: Tap::Last, weights: [1.0; STAGES], input: Input::Plain, bf16: false, name };
        let (blurred, sharp) = calibration_batch(device);
        random.calibrate(&blurred, &sharp)?;
        Ok(random)
    }

    /// Sets whether features are computed in bf16.
    #[must_use]
    pub fn with_bf16(mut self, bf16: bool) -> Self {
        self.bf16 = bf16;
        self
    }

    /// Stage weights.
    pub fn weights(&self) -> [f64; STAGES] {
        self.weights
    }

    /// Calibrates the stage weights: each stage contributes equally to the distance of `output` from `reference`, and
    /// the sum equals their mean absolute difference.
    ///
    /// # Errors
    /// Errors of [`Perceptual::distance`].
    pub fn calibrate(&mut self, output: &Tensor, reference: &Tensor) -> Result<()> {
        tch::no_grad(|| {
            let plain = mean(&(output - reference).abs()).double_value(&[]);
            let each = self.stage_distances(output, reference)?;
            for (weight, distance) in self.weights.iter_mut().zip(each) {
                *weight = plain / (STAGES as f64 * mean(&distance).double_value(&[])).max(f64::MIN_POSITIVE);
            }
            Ok(())
        })
    }

    /// Mean absolute difference of each stage's features, per picture: \[N\].
    fn stage_distances(&self, output: &Tensor, reference: &Tensor) -> Result<Vec<Tensor>> {
        let [output, reference] = features(&self.vgg, self.tap, self.input, self.bf16, [output, reference])?;
        // Differences are summed in the kind of the pictures, even if features are bf16.
        Ok(output.iter().zip(&reference).map(|(a, b)| means(&(a - b).abs())).collect())
    }
}

impl Perceptual for VggDistance {
    fn distances(&self, output: &Tensor, reference: &Tensor) -> Result<Tensor> {
        let each = self.stage_distances(output, reference)?;
        let zero = super::zeros(output);
        Ok(each.into_iter().zip(self.weights).fold(zero, |sum, (distance, weight)| sum + distance * weight))
    }

    fn name(&self) -> &'static str {
        self.name
    }
}

/// LPIPS 0.1 with VGG-16: Zhang et al., "The unreasonable effectiveness of deep features as a perceptual metric"
/// (2018).
#[derive(Debug)]
pub struct Lpips {
    vgg: Vgg,
    /// Channel weights of each stage: \[1, channels, 1, 1\].
    heads: Vec<Tensor>,
    bf16: bool,
}

impl Lpips {
    /// Builds the measure from `tensors`: VGG-16 in the form of [`Vgg::new`], and `lin{s}.model.1.weight` \[1,
    /// channels, 1, 1\] for the five stages s.
    ///
    /// # Errors
    /// Weights that are missing or do not fit each other.
    pub fn new(tensors: &std::collections::BTreeMap<String, Tensor>, device: Device) -> Result<Self> {
        let vgg = Vgg::new(Depth::Vgg16, tensors, device)?;
        let heads = vgg.channels().into_iter().enumerate().map(|(stage, channels)| {
            let name = format!("lin{stage}.model.1.weight");
            let mend = "give LPIPS's own weights/v0.1/vgg.pth with `--heads`";
            let missing = || wrong(Depth::Vgg16, &format!("the head `{name}` is missing ({mend})"));
            let head = tensors.get(&name).ok_or_else(missing)?;
            let (shape, expected) = (head.size(), [1, channels, 1, 1]);
            if shape != expected {
                return Err(wrong(Depth::Vgg16, &format!("`{name}` is {shape:?}, not {expected:?}")));
            }
            Ok(head.detach().to_kind(Kind::Float).to_device(device))
        });
        Ok(Self { heads: heads.collect::<Result<_>>()?, vgg, bf16: false })
    }

    /// Sets whether features are computed in bf16.
    #[must_use]
    pub fn with_bf16(mut self, bf16: bool) -> Self {
        self.bf16 = bf16;
        self
    }
}

impl Perceptual for Lpips {
    fn distances(&self, output: &Tensor, reference: &Tensor) -> Result<Tensor> {
        let pictures = [output, reference];
        let [output, reference] = features(&self.vgg, Tap::LastRelu, Input::Lpips, self.bf16, pictures)?;
        let mut sum = super::zeros(pictures[0]);
        for ((a, b), head) in output.iter().zip(&reference).zip(&self.heads) {
            let difference = (normalised(a) - normalised(b)).square() * head.to_kind(a.kind());
            sum += means(&difference.sum_dim_intlist([1i64].as_slice(), true, None));
        }
        Ok(sum)
    }

    fn name(&self) -> &'static str {
        "LPIPS (VGG-16)"
    }
}

/// Transformation of pictures in 0…1 to the input of a network.
#[derive(Debug, Clone, Copy)]
enum Input {
    /// Unchanged.
    Plain,
    /// Standardised with mean and standard deviation of ImageNet.
    ImageNet,
    /// Scaled to −1…1, then standardised with LPIPS's mean and standard deviation.
    Lpips,
}

impl Input {
    fn of(self, pictures: &Tensor) -> Tensor {
        let (scale, mean, deviation) = match self {
            Self::Plain => return pictures.shallow_clone(),
            Self::ImageNet => (1.0, [0.485, 0.456, 0.406], [0.229, 0.224, 0.225]),
            Self::Lpips => (2.0, [-0.030, -0.088, -0.188], [0.458, 0.448, 0.450]),
        };
        let colour = |values: [f64; 3]| {
            Tensor::from_slice(&values)
                .view([1, 3, 1, 1])
                .to_kind(pictures.kind())
                .to_device(pictures.device())
        };
        (pictures * scale - (scale - 1.0) - colour(mean)) / colour(deviation)
    }
}

/// Features of `output` and `reference` in the kind of the pictures. The reference receives no gradients.
fn features(
    vgg: &Vgg,
    tap: Tap,
    input: Input,
    bf16: bool,
    [output, reference]: [&Tensor; 2],
) -> Result<[Vec<Tensor>; 2]> {
    picture_shape(output, reference)?;
    let kind = output.kind();
    let look = |pictures: &Tensor| -> Result<Vec<Tensor>> {
        let pictures = input.of(pictures);
        let pictures = if bf16 { pictures.to_kind(Kind::BFloat16) } else { pictures };
        Ok(vgg.features(&pictures, tap)?.iter().map(|map| map.to_kind(kind)).collect())
    };
    Ok([look(output)?, tch::no_grad(|| look(reference))?])
}

/// Normalises `features` \[N, C, H, W\] to length 1 at every pixel.
fn normalised(features: &Tensor) -> Tensor {
    // LPIPS adds epsilon to the length only, whose gradient at 0 is infinite; clamping avoids that.
    let squares = features.square().sum_dim_intlist([1i64].as_slice(), true, None);
    features / (squares.clamp_min(LPIPS_EPSILON * LPIPS_EPSILON).sqrt() + LPIPS_EPSILON)
}

/// Synthetic calibration pictures: blurred copies first, then the sharp originals.
fn calibration_batch(device: Device) -> (Tensor, Tensor) {
    let options = (Kind::Float, device);
    let [height, width] = CALIBRATION;
    let x = Tensor::arange(width, options).view([1, 1, 1, width]) / width as f64;
    let y = Tensor::arange(height, options).view([1, 1, height, 1]) / height as f64;
    let phase = |count: i64, step: f64, axis: usize| {
        let mut shape = [1; 4];
        shape[axis] = count;
        Tensor::arange(count, options).view(shape) * step
    };
    let (picture, colour) = (phase(4, 1.9, 0), phase(3, 0.7, 1));
    // Gratings of four octaves, and step edges from the sign of another.
    let wave = |fx: f64, fy: f64| (&x * fx + &y * fy + &picture * (1.0 + 0.1 * fx) + &colour).sin();
    let gratings =
        wave(7.0, 4.0) * 0.15 + wave(-11.0, 17.0) * 0.12 + wave(41.0, 23.0) * 0.09 + wave(-71.0, 89.0) * 0.06;
    let sharp = (gratings + wave(5.0, -9.0).sign() * 0.15 + 0.5).clamp(0.0, 1.0);
    let small = sharp.avg_pool2d([4, 4], [4, 4], [0, 0], false, true, None);
    (small.upsample_bilinear2d([height, width], false, None, None), sharp)
}

#[cfg(test)]
mod tests {
    use super::super::testing::{pair, value, worst_slope};
    use super::*;

    #[test]
    fn gradients_of_pictures_are_differences_to_neighbours() {
        let reference = Tensor::from_slice(&[0.0, 0.5, 0.25, 1.0, 0.0, 0.5]).view([1, 1, 2, 3]);
        let output = reference.zeros_like();
        // Differences down are 1.0 and −0.5; to the right 0.5 and −0.25.
        let expected = (1.0 + 0.5 + 0.5 + 0.25) / 4.0;
        assert!((value(&gradient_l1(&output, &reference).unwrap()) - expected).abs() < 1e-12);
    }

    #[test]
    fn the_default_is_a_loss_with_a_gradient() {
        let (output, reference) = pair([2, 24, 26], 0.4);
        let measure = L1MsSsim::default();
        assert!(value(&measure.distance(&reference, &reference).unwrap()).abs() < 1e-12);
        let worst = worst_slope(&[output.shallow_clone()], |inputs| {
            measure.distance(&inputs[0], &reference).unwrap()
        });
        assert!(worst < 1e-6, "{worst:e}");
    }
}
