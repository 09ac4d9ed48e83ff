//! Compares losses with PyTorch, pytorch-msssim and lpips. `tests/reference/training/make_losses.py` made the values.

use super::perceptual::{Lpips, VggDistance, gradient_l1};
use super::testing::{EXACT, value, worst_slope};
use super::vgg::{Depth, Vgg};
use super::*;
use super::{flow::FlowSearch, ssim};
use safetensors::SafeTensors;
use serde_json::Value;
use std::collections::BTreeMap;
use tch::Kind;

const CASES: &[u8] = include_bytes!("../../../../tests/reference/training/losses.safetensors");
const VGG19: &[u8] = include_bytes!("../../../../tests/reference/training/losses_vgg19.safetensors");
const VGG16: &[u8] = include_bytes!("../../../../tests/reference/training/losses_vgg16.safetensors");

/// Tensors of a file in double precision.
fn tensors(bytes: &[u8]) -> BTreeMap<String, Tensor> {
    let kind = |dtype| match dtype {
        safetensors::Dtype::U8 => Kind::Uint8,
        safetensors::Dtype::I8 => Kind::Int8,
        safetensors::Dtype::F16 => Kind::Half,
        safetensors::Dtype::F32 => Kind::Float,
        other => panic!("{other:?}"),
    };
    let file = SafeTensors::deserialize(bytes).unwrap();
    let tensor = |view: safetensors::tensor::TensorView<'_>| {
        let shape: Vec<i64> = view.shape().iter().map(|&side| side as i64).collect();
        Tensor::from_data_size(view.data(), &shape, kind(view.dtype())).to_kind(Kind::Double)
    };
    file.tensors().into_iter().map(|(name, view)| (name, tensor(view))).collect()
}

struct Cases {
    tensors: BTreeMap<String, Tensor>,
    values: Value,
}

impl Cases {
    fn new() -> Self {
        let (_, header) = SafeTensors::read_metadata(CASES).unwrap();
        let values = serde_json::from_str(&header.metadata().as_ref().unwrap()["values"]).unwrap();
        Self { tensors: tensors(CASES), values }
    }

    fn outputs(&self) -> Vec<Tensor> {
        let bytes = &self.tensors["outputs"];
        let apart = Tensor::arange(bytes.numel() as i64, EXACT).view_as(bytes).remainder(997.0) * 1e-6;
        (bytes / 255.0 + apart).unbind(0)
    }

    fn references(&self) -> Vec<Tensor> {
        (&self.tensors["references"] / 255.0).unbind(0)
    }

    fn motion(&self) -> Vec<Tensor> {
        (&self.tensors["motion"] / 8.0).unbind(0)
    }

    fn assert_value(&self, name: &str, found: &Tensor) {
        let (found, expected) = (value(found), self.values[name].as_f64().unwrap());
        assert!((found - expected).abs() < 1e-6 * expected.abs(), "{name}: {found}, not {expected}");
    }

    /// Loss of the clip under `config`, with `measure` as perceptual measure.
    fn terms(&self, config: LossConfig, measure: VggDistance, outputs: &[Tensor]) -> Terms {
        let losses = Losses { config, perceptual: Box::new(measure) };
        let (references, motion) = (self.references(), self.motion());
        losses.clip(&Clip { outputs, references: &references, motion: Some(&motion) }).unwrap()
    }
}

fn vgg19() -> Vgg {
    Vgg::new(Depth::Vgg19, &tensors(VGG19), Device::Cpu).unwrap()
}

fn lpips() -> Lpips {
    Lpips::new(&tensors(VGG16), Device::Cpu).unwrap()
}

/// Pictures computed from integers, as in `make_losses.py`.
fn large_pair() -> [Tensor; 2] {
    let triangle = |k: i64, period: i64| (k % (2 * period) - period).abs() * 255 / period;
    let mut both = [Vec::new(), Vec::new()];
    for c in 0..3 {
        for y in 0..167 {
            for x in 0..190 {
                let waves = triangle(3 * x + y + 20 * c, 64) + triangle(2 * y + 200 - x, 23);
                let reference = (waves + (x * y * (c + 3)) % 97) / 3;
                let output = (reference + (x * 7 + y * 13 + c * 5) % 41 - 20).clamp(0, 255);
                both[0].push(reference as f64 / 255.0);
                both[1].push(output as f64 / 255.0);
            }
        }
    }
    both.map(|values| Tensor::from_slice(&values).view([1, 3, 167, 190]))
}

#[test]
fn similarities_are_those_of_pytorch_msssim() {
    let cases = Cases::new();
    let (output, reference) = (&cases.outputs()[3], &cases.references()[3]);
    cases.assert_value("ssim", &ssim::ssim(output, reference).unwrap());
    let [reference, output] = large_pair();
    cases.assert_value("ssim_large", &ssim::ssim(&output, &reference).unwrap());
    cases.assert_value("ms_ssim_large", &ssim::ms_ssim(&output, &reference).unwrap());
}

#[test]
fn perceptual_measures_are_those_of_the_authors_and_of_lpips() {
    let cases = Cases::new();
    let (output, reference) = (&cases.outputs()[3], &cases.references()[3]);
    let measures: [(&str, Box<dyn Perceptual>); 3] = [
        ("fovolnet_vgg", Box::new(VggDistance::fovolnet(vgg19()))),
        ("deepfovea_vgg", Box::new(VggDistance::deepfovea(vgg19()))),
        ("lpips", Box::new(lpips())),
    ];
    for (name, measure) in measures {
        cases.assert_value(name, &measure.distance(output, reference).unwrap());
    }
    cases.assert_value("gradient_l1", &gradient_l1(output, reference).unwrap());
}

#[test]
fn the_loss_is_that_of_the_paper_with_its_gradient() {
    let cases = Cases::new();
    let config = LossConfig { flow: FlowSource::Exact, ..LossConfig::default() };
    let leaves: Vec<Tensor> = cases.outputs().iter().map(|y| y.copy().set_requires_grad(true)).collect();
    let terms = cases.terms(config, VggDistance::fovolnet(vgg19()), &leaves);
    terms.total.backward();
    let Terms { total, spatial, perceptual, l1, temporal, flow, squares: _, coarse: _ } = &terms;
    let named = [
        ("total", total),
        ("spatial", spatial),
        ("perceptual", perceptual),
        ("l1", l1),
        ("temporal", temporal),
    ];
    for (name, term) in named.into_iter().chain([("flow", flow)]) {
        cases.assert_value(&format!("paper.{name}"), term);
    }
    let gradients: Vec<Tensor> = leaves.iter().map(|leaf| leaf.grad().view([-1])).collect();
    let every = Tensor::cat(&gradients, 0).slice(0, None, None, 11);
    let expected = &cases.tensors["gradient"];
    let worst = (every - expected).abs().max().double_value(&[]) / expected.abs().max().double_value(&[]);
    assert!(worst < 1e-6, "{worst:e}");
}

#[test]
fn the_losses_of_deepfovea_are_as_written() {
    let cases = Cases::new();
    let outputs = cases.outputs();
    let nothing = PerceptualConfig::default;
    let config = LossConfig { flow: FlowSource::Exact, ..LossConfig::deepfovea_fvn(nothing()) };
    let terms = cases.terms(config, VggDistance::fovolnet(vgg19()), &outputs);
    cases.assert_value("deepfovea_fvn", &terms.total);
    let config = LossConfig::deepfovea(nothing(), FlowSource::Exact);
    let terms = cases.terms(config, VggDistance::deepfovea(vgg19()), &outputs);
    cases.assert_value("deepfovea", &terms.total);
}

#[test]
fn warping_is_sampling_and_block_matching_finds_the_same_offsets() {
    let cases = Cases::new();
    let (references, motion) = (cases.references(), cases.motion());
    let warped = flow::warp(&references[0], &motion[1]);
    assert!(warped.allclose(&cases.tensors["warped"], 1e-6, 1e-7, false));
    let offsets = FlowSearch::single_level().motion(&references[1], &references[0]);
    assert_eq!((offsets - &cases.tensors["offsets"]).abs().max().double_value(&[]), 0.0);
}

#[test]
fn gradients_of_perceptual_measures_are_differences() {
    let cases = Cases::new();
    let (output, reference) = (&cases.outputs()[2], &cases.references()[2]);
    let random = VggDistance::random(3, Device::Cpu).unwrap();
    let measures: [Box<dyn Perceptual>; 4] = [
        Box::new(VggDistance::fovolnet(vgg19())),
        Box::new(VggDistance::deepfovea(vgg19())),
        Box::new(lpips()),
        Box::new(random),
    ];
    for measure in measures {
        let worst =
            worst_slope(&[output.shallow_clone()], |inputs| measure.distance(&inputs[0], reference).unwrap());
        assert!(worst < 1e-5, "{}: {worst:e}", measure.name());
        assert!(value(&measure.distance(reference, reference).unwrap()).abs() < 1e-12);
    }
}

#[test]
fn random_features_weigh_the_same_and_follow_from_their_seed() {
    let cases = Cases::new();
    let [output, reference] =
        [cases.outputs(), cases.references()].map(|frames| frames[1].to_kind(Kind::Float));
    let distance = |seed: u64| {
        let measure = VggDistance::random(seed, Device::Cpu).unwrap();
        value(&measure.distance(&output, &reference).unwrap())
    };
    let plain = value(&(&output - &reference).abs().mean(None));
    let first = distance(1);
    assert_eq!(first, distance(1));
    assert_ne!(first, distance(2));
    assert!(first > 0.2 * plain && first < 5.0 * plain, "{first}, and {plain} without features");
    let mut measure = VggDistance::random(1, Device::Cpu).unwrap();
    measure.calibrate(&output, &reference).unwrap();
    let after = value(&measure.distance(&output, &reference).unwrap());
    assert!((after - plain).abs() < 1e-4 * plain, "{after}, not {plain}");
}

#[test]
fn bf16_is_near_f32() {
    let cases = Cases::new();
    let [output, reference] =
        [cases.outputs(), cases.references()].map(|frames| frames[3].to_kind(Kind::Float));
    let exact = value(&VggDistance::fovolnet(vgg19()).distance(&output, &reference).unwrap());
    let short = VggDistance::fovolnet(vgg19()).with_bf16(true);
    let leaf = output.copy().set_requires_grad(true);
    let found = short.distance(&leaf, &reference).unwrap();
    assert!((value(&found) - exact).abs() < 0.02 * exact, "{found} {exact}");
    found.backward();
    assert_eq!(leaf.grad().kind(), Kind::Float);
}

#[test]
fn configured_measures_read_their_files() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("vgg19.safetensors");
    std::fs::write(&path, VGG19).unwrap();
    let text = format!("perceptual = {{ measure = \"fovolnet-vgg\", weights = {path:?} }}");
    let config: LossConfig = toml::from_str(&text).unwrap();
    let losses = Losses::new(&config, Device::Cpu).unwrap();
    assert_eq!(losses.perceptual().name(), "VGG-19 features");
    let cases = Cases::new();
    let found = losses.perceptual().distance(&cases.outputs()[3], &cases.references()[3]).unwrap();
    cases.assert_value("fovolnet_vgg", &found);
    let other = PerceptualConfig::Lpips(VggFile { weights: path, bf16: false });
    let message = other.build(Device::Cpu).unwrap_err().to_string();
    assert!(message.contains("no weights of VGG-16"), "{message}");
    let tiny = Tensor::zeros([1, 3, 15, 40], EXACT);
    assert!(losses.perceptual().distance(&tiny, &tiny).is_err());
}
