//! Tests of networks under autograd against the CPU engine, PyTorch's cases and finite differences.

use fovol_core::{Frame, FrameSize, SparseFrame};
use fovol_net::Weights;
use fovol_net::cpu::{self, FrameInput, Precision, Simd};
use fovol_net::plan::{
    Accumulation, DeepFoveaConfig, Direct, Feedback, Fill, Filtering, Fresh, Kernels, Named, NetworkConfig,
    Normalisation, Prediction, Taps, WNetConfig,
};
use fovol_net::weights::Storage;
use fovol_train::network::{Inputs, Network, Options, Spread, initial_weights};
use safetensors::SafeTensors;
use std::collections::HashMap;
use std::path::PathBuf;
use tch::{Device, Kind, Tensor};

/// Colour, mask and motion of one frame of a batch of clips.
struct Given {
    colour: Tensor,
    mask: Tensor,
    motion: Tensor,
}

impl Given {
    fn inputs(&self) -> Inputs<'_> {
        Inputs { colour: &self.colour, mask: Some(&self.mask), motion: Some(&self.motion) }
    }

    /// Moving pattern sampled at 20 % of the pixels, with swirling motion that also leads out of the frame.
    fn new(batch: i64, width: i64, height: i64, t: i64) -> Self {
        let options = (Kind::Float, Device::Cpu);
        let x = Tensor::arange(width, options).view([1, 1, 1, width]);
        let y = Tensor::arange(height, options).view([1, 1, height, 1]);
        let n = Tensor::arange(batch, options).view([batch, 1, 1, 1]);
        let t = t as f64;
        let wave = |fx: f64, fy: f64, ft: f64| (&x * fx + &y * fy + &n * 2.0 + t * ft).sin();
        let mask = (wave(12.9898, 78.233, 3.1) * 43758.547).frac().abs().lt(0.2).to_kind(Kind::Float);
        let colour = Tensor::cat(&[wave(0.2, 0.1, 0.4), wave(0.1, 0.3, 0.2), wave(0.3, 0.05, 0.6)], 1);
        let colour = (colour * 0.4 + 0.5) * &mask;
        let motion = Tensor::cat(&[wave(0.11, 0.07, 0.5), wave(0.09, -0.13, 0.7)], 1) * 3.0;
        Self { colour, mask, motion }
    }

    /// The first clip's frame as input of the CPU engine.
    fn frame(&self) -> (SparseFrame, Vec<[f32; 2]>) {
        let [colour, mask, motion] = [&self.colour, &self.mask, &self.motion].map(|t| numbers(&t.get(0)));
        let (height, width) = (self.colour.size()[2], self.colour.size()[3]);
        let n = (height * width) as usize;
        let pixels = (0..n).map(|i| [colour[i], colour[n + i], colour[2 * n + i], mask[i]]).collect();
        let size = FrameSize::new(width as u32, height as u32).unwrap();
        let motion = (0..n).map(|i| [motion[i], motion[n + i]]).collect();
        (SparseFrame::from(&Frame::from_pixels(size, pixels).unwrap()), motion)
    }
}

fn numbers(tensor: &Tensor) -> Vec<f32> {
    Vec::try_from(tensor.detach().to_kind(Kind::Float).contiguous().view([-1])).unwrap()
}

/// Largest difference, relative to the largest expected value.
fn difference(found: &[f32], expected: &[f32]) -> f32 {
    assert_eq!(found.len(), expected.len());
    let most = expected.iter().fold(1e-6f32, |most, v| most.max(v.abs()));
    found.iter().zip(expected).fold(0.0f32, |worst, (a, b)| worst.max((a - b).abs())) / most
}

/// Converts interleaved pixels of `channels` values to planes \[channel\]\[row\]\[column\].
fn planes(data: &[f32], channels: usize) -> Vec<f32> {
    (0..channels).flat_map(|c| data.chunks_exact(channels).map(move |pixel| pixel[c])).collect()
}

/// Largest difference of pictures and states from the CPU engine over five frames.
fn worst_against_engine(config: &NetworkConfig, options: Options, [width, height]: [i64; 2]) -> f32 {
    let weights = Weights::random(config, 5).unwrap();
    let engine = cpu::Network::new(config.plan().unwrap(), &weights, Simd::best(), Precision::F32).unwrap();
    let network = Network::new(&weights, options, Device::Cpu).unwrap();
    let size = FrameSize::new(width as u32, height as u32).unwrap();
    let mut theirs = engine.state(size);
    let mut ours = network.initial_state([1, height, width]);
    let mut worst = 0.0f32;
    for t in 0..5 {
        let given = Given::new(1, width, height, t);
        let (sparse, motion) = given.frame();
        let expected =
            engine.reconstruct(&FrameInput { sparse: &sparse, motion: Some(&motion) }, &mut theirs).unwrap();
        let (picture, next) = network.forward(&given.inputs(), ours).unwrap();
        ours = next;
        let expected: Vec<f32> = expected.pixels().iter().flat_map(|p| [p[0], p[1], p[2]]).collect();
        worst = worst.max(difference(&numbers(&picture.clamp(0.0, 1.0)), &planes(&expected, 3)));
    }
    for (stored, ours) in engine.carried(&theirs).iter().zip(&ours) {
        let map = stored.to_f32();
        worst = worst.max(difference(&numbers(ours), &planes(&map.data, map.channels)));
    }
    worst
}

#[test]
fn networks_agree_with_the_cpu_engine() {
    for named in Named::ALL {
        for size in [[45, 37], [64, 33]] {
            let worst = worst_against_engine(&named.config(), Options::default(), size);
            println!("{named} {size:?}: {worst:.1e}");
            assert!(worst <= 1e-4, "{named} {size:?}: {worst}");
        }
        let last = Options { channels_last: true, ..Options::default() };
        let worst = worst_against_engine(&named.config(), last, [45, 37]);
        assert!(worst <= 1e-4, "{named} with channels last: {worst}");
    }
}

#[test]
fn bf16_stays_close() {
    for named in Named::ALL {
        for channels_last in [false, true] {
            let options = Options { channels_last, bf16: true, ..Options::default() };
            let worst = worst_against_engine(&named.config(), options, [45, 37]);
            println!("{named} channels last {channels_last}: {worst:.1e}");
            assert!((1e-5..0.05).contains(&worst), "{named} channels last {channels_last}: {worst}");
        }
    }
}

/// Case of `tests/reference/network/make_cases.py`.
struct Case {
    bytes: Vec<u8>,
    facts: HashMap<String, String>,
}

impl Case {
    fn read(path: &PathBuf) -> Self {
        let bytes = std::fs::read(path).unwrap();
        let (_, header) = SafeTensors::read_metadata(&bytes).unwrap();
        let facts = header.metadata().clone().unwrap_or_default();
        Self { bytes, facts }
    }

    fn number(&self, key: &str) -> i64 {
        self.facts[key].parse().unwrap()
    }

    fn tensor(&self, name: &str) -> Option<Tensor> {
        let file = SafeTensors::deserialize(&self.bytes).unwrap();
        let view = file.tensor(name).ok()?;
        let shape: Vec<i64> = view.shape().iter().map(|&side| side as i64).collect();
        Some(Tensor::from_data_size(view.data(), &shape, Kind::Float).to_kind(Kind::Double).unsqueeze(0))
    }

    /// Largest difference of pictures and states.
    fn worst(&self, network: &Network) -> f32 {
        let mut state = network.initial_state([1, self.number("height"), self.number("width")]);
        let mut worst = 0.0f32;
        for t in 0..self.number("frames") {
            let part = |name: &str| self.tensor(&format!("{name}.{t}"));
            let (colour, mask, motion) = (part("input").unwrap(), part("mask"), part("motion"));
            let inputs = Inputs { colour: &colour, mask: mask.as_ref(), motion: motion.as_ref() };
            let (picture, next) = network.forward(&inputs, state).unwrap();
            state = next;
            let expected = numbers(&part("output").unwrap());
            worst = worst.max(difference(&numbers(&picture.clamp(0.0, 1.0)), &expected));
        }
        for (tensor, kept) in state.iter().zip(network.plan().states()) {
            if let Some(expected) = self.tensor(&format!("state.{}", kept.name)) {
                worst = worst.max(difference(&numbers(tensor), &numbers(&expected)));
            }
        }
        worst
    }
}

#[test]
fn networks_agree_with_pytorch() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../crates/fovol-net/tests/reference");
    let files = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let is_case = |path: &PathBuf| {
        let stem = path.file_stem().unwrap().to_string_lossy().into_owned();
        stem.contains('x') && path.extension().is_some_and(|e| e == "safetensors")
    };
    let cases: Vec<PathBuf> = files.filter(is_case).collect();
    assert!(cases.len() >= 12, "cases are missing: {cases:?}");
    for path in cases {
        let case = Case::read(&path);
        let config: NetworkConfig = serde_json::from_str(&case.facts["config"]).unwrap();
        let weights = Weights::random(&config, case.number("seed") as u64).unwrap();
        let network = Network::new(&weights, Options::default(), Device::Cpu).unwrap().into_double();
        let worst = case.worst(&network);
        // The cases are rounded to f32; everything else is double.
        assert!(worst <= 2e-7, "{}: {worst}", path.display());
    }
}

/// Mean squares of three frames' pictures and of the last state, as one number.
fn energy(network: &Network) -> Tensor {
    let mut state = network.initial_state([2, 9, 13]);
    let mut sum = Tensor::from(0.0).to_kind(Kind::Double);
    for t in 0..3 {
        let (picture, next) = network.forward(&Given::new(2, 13, 9, t).inputs(), state).unwrap();
        state = next;
        sum += picture.square().mean(Kind::Double);
    }
    state.iter().fold(sum, |sum, tensor| sum + tensor.square().mean(Kind::Double) * 0.1)
}

#[test]
fn gradients_of_clips_agree_with_differences() {
    let direct = Direct { residual: true };
    // The confidence has no gradients.
    let fresh = |coarse| Fresh { taps: Taps::Centre, coarse, history_confidence: false };
    let fill = |coarse| {
        let accumulation = Accumulation { weight: 0.98, points: true, fresh: Some(fresh(coarse)) };
        Fill { corrections: 1, accumulation: Some(accumulation) }
    };
    let kernels = WNetConfig::fast().options().kernels().unwrap();
    let all_on = WNetConfig::fast().with(|options| {
        (options.encoder, options.decoder) = (vec![4, 5, 6], vec![3, 4]);
        options.fill = Some(fill(true));
        let filtering = Filtering::Once { direct: Some((direct, Taps::Centre)) };
        options.prediction = Prediction::Kernels(Kernels { filtering, ..kernels });
    });
    let all_on = all_on.unwrap();
    let softmax = all_on.with(|options| {
        options.feedback = Feedback::Direct;
        options.fold = false;
        options.fill = Some(fill(false));
        let filtering = Filtering::EveryLevel { direct: Some(direct) };
        let normalisation = Normalisation::Softmax;
        options.prediction = Prediction::Kernels(Kernels { normalisation, filtering, ..kernels });
    });
    let softmax = softmax.unwrap();
    let fovea = DeepFoveaConfig { encoder: vec![3, 4], bottleneck: 5 };
    let configs =
        [NetworkConfig::WNet(all_on), NetworkConfig::WNet(softmax), NetworkConfig::DeepFovea(fovea)];
    for config in configs {
        let weights = Weights::random(&config, 4).unwrap();
        let network = Network::new(&weights, Options::default(), Device::Cpu).unwrap().into_double();
        energy(&network).backward();
        let mut checked = 0;
        for (name, parameter) in network.parameters() {
            let gradient = parameter.grad().reshape([-1]);
            let place = gradient.abs().argmax(None, false).int64_value(&[]);
            let moved = |by: f64| {
                tch::no_grad(|| {
                    let _ = parameter.view([-1]).narrow(0, place, 1).g_add_scalar_(by);
                    let energy = energy(&network).double_value(&[]);
                    let _ = parameter.view([-1]).narrow(0, place, 1).g_add_scalar_(-by);
                    energy
                })
            };
            let found = gradient.double_value(&[place]);
            // A long step may cross the kink of a ReLU; a short one suffers from rounding.
            let is_near = |step: f64| {
                let expected = (moved(step) - moved(-step)) / (2.0 * step);
                (found - expected).abs() <= 1e-5 * expected.abs() + 1e-8
            };
            assert!([1e-6, 1e-7, 1e-8].into_iter().any(is_near), "{name}: {found} is no difference");
            checked += usize::from(found != 0.0);
        }
        assert!(checked * 10 > network.parameters().len() * 9, "{checked} gradients are not zero");
    }
}

#[test]
fn clips_of_a_batch_do_not_mix() {
    let weights = Weights::random(&Named::WNetFast.config(), 1).unwrap();
    let network = Network::new(&weights, Options::default(), Device::Cpu).unwrap();
    let run = |of: &dyn Fn(&Tensor) -> Tensor, batch: i64| {
        let mut state = network.initial_state([batch, 20, 40]);
        let mut last = Tensor::default();
        for t in 0..3 {
            let given = Given::new(3, 40, 20, t);
            let [colour, mask, motion] = [&given.colour, &given.mask, &given.motion].map(of);
            let given = Given { colour, mask, motion };
            (last, state) = network.forward(&given.inputs(), state).unwrap();
        }
        last
    };
    let together = run(&|tensor| tensor.shallow_clone(), 3);
    let alone = run(&|tensor| tensor.narrow(0, 1, 1), 1);
    assert!(difference(&numbers(&together.narrow(0, 1, 1)), &numbers(&alone)) < 1e-5);
}

#[test]
fn weights_go_out_and_come_back() {
    let first = initial_weights(&Named::WNetFast.config(), Spread::Pytorch, 1).unwrap();
    let mut network = Network::new(&first, Options::default(), Device::Cpu).unwrap();
    assert_eq!(network.weights(), first);
    let names: Vec<String> = network.plan().parameters().into_iter().map(|p| p.name).collect();
    let handles = network.parameters();
    assert!(handles.iter().map(|(name, _)| name).eq(&names));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("w.safetensors");
    let second = initial_weights(&Named::WNetFast.config(), Spread::Pytorch, 2).unwrap();
    std::fs::write(&path, second.to_bytes(Storage::F32).unwrap()).unwrap();
    network.load(&Weights::read(&path).unwrap()).unwrap();
    assert_eq!(network.weights(), second);
    assert_eq!(numbers(&handles[0].1), second.values(&names[0]).unwrap());
    assert!(handles.iter().all(|(_, tensor)| tensor.requires_grad() && tensor.is_leaf()));
    assert!(
        network.load(&initial_weights(&Named::WNetNarrow.config(), Spread::Pytorch, 1).unwrap()).is_err()
    );
}

#[test]
fn what_does_not_fit_is_said_in_a_line() {
    let weights = initial_weights(&Named::WNetFast.config(), Spread::Pytorch, 1).unwrap();
    let network = Network::new(&weights, Options::default(), Device::Cpu).unwrap();
    let given = Given::new(1, 20, 10, 0);
    let state = || network.initial_state([1, 10, 20]);
    let message = |inputs: &Inputs<'_>, state| {
        let message = network.forward(inputs, state).unwrap_err().to_string();
        assert!(!message.contains('\n'));
        message
    };
    let sound = given.inputs();
    assert!(message(&Inputs { mask: None, ..sound }, state()).contains("needs the mask"));
    assert!(message(&Inputs { mask: Some(&given.motion), ..sound }, state()).contains("[1, 1, 10, 20]"));
    assert!(message(&Inputs { colour: &given.mask, ..sound }, state()).contains("[batch, 3, rows, columns]"));
    assert!(message(&sound, network.initial_state([1, 50, 20])).contains("begin a new one"));
    assert!(message(&sound, Vec::new()).contains("begin a new one"));
    // Missing motion means no motion.
    let still = given.motion.zeros_like();
    let (a, _) = network.forward(&Inputs { motion: None, ..sound }, state()).unwrap();
    let (b, _) = network.forward(&Inputs { motion: Some(&still), ..sound }, state()).unwrap();
    assert_eq!(numbers(&a), numbers(&b));
}
