//! Compares whole networks with PyTorch in double precision; `tests/reference/network/make_cases.py` made the
//! cases.

mod cases;

use cases::{Case, cases, difference, frame};
use fovol_core::{FrameSize, SparseFrame};
use fovol_net::Weights;
use fovol_net::cpu::{FrameInput, Network, Precision, Simd};
use fovol_net::plan::NetworkConfig;
use fovol_net::weights::StateDict;
use half::{bf16, f16};
use std::path::{Path, PathBuf};

/// Tolerance, relative to the largest value.
const TOLERANCE: f32 = 1e-5;

#[test]
fn networks_agree_with_pytorch() {
    let cases = cases();
    assert!(cases.len() >= 12, "cases are missing: {cases:?}");
    for path in cases {
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        let case = Case::read(&path);
        let size = FrameSize::new(case.number("width"), case.number("height")).unwrap();
        let config: NetworkConfig = serde_json::from_str(&case.facts["config"]).unwrap();
        let weights = Weights::random(&config, u64::from(case.number("seed"))).unwrap();
        for simd in Simd::available() {
            let network = Network::new(config.plan().unwrap(), &weights, simd, Precision::F32).unwrap();
            let worst = run(&case, size, &network);
            println!("{name} {simd}: {worst:.1e}");
            assert!(worst <= TOLERANCE, "{name} {simd}: {worst}");
        }
    }
}

/// Largest difference of any picture or state.
fn run(case: &Case, size: FrameSize, network: &Network) -> f32 {
    let mut state = network.state(size);
    let mut worst = 0.0f32;
    for t in 0..case.number("frames") {
        let values = |name: &str| case.values(&format!("{name}.{t}"));
        let sparse = SparseFrame::from(&frame(size, &values("input").unwrap(), &values("mask").unwrap()));
        let motion: Option<Vec<[f32; 2]>> = values("motion").map(|planes| {
            let n = size.pixels();
            (0..n).map(|i| [planes[i], planes[n + i]]).collect()
        });
        let input = FrameInput { sparse: &sparse, motion: motion.as_deref() };
        let out = network.reconstruct(&input, &mut state).unwrap();
        let planes: Vec<f32> = (0..3).flat_map(|c| out.pixels().iter().map(move |p| p[c])).collect();
        worst = worst.max(difference(&planes, &values("output").unwrap()));
    }
    for (stored, kept) in network.carried(&state).iter().zip(network.plan().states()) {
        let map = stored.to_f32();
        let planes: Vec<f32> = (0..map.channels)
            .flat_map(|c| map.data.chunks_exact(map.channels).map(move |pixel| pixel[c]))
            .collect();
        if let Some(expected) = case.values(&format!("state.{}", kept.name)) {
            worst = worst.max(difference(&planes, &expected));
        } else {
            let expected = case.values(&format!("state_samples.{}", kept.name)).unwrap();
            let samples: Vec<f32> =
                planes.iter().step_by((planes.len() / 64).max(1)).take(64).copied().collect();
            worst = worst.max(difference(&samples, &expected));
        }
    }
    worst
}

/// Path of a file in `tests/reference`.
fn reference(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/reference").join(name)
}

#[test]
fn weights_files_of_pytorch_are_read() {
    let weights = Weights::read(&reference("state_dict.safetensors")).unwrap();
    weights.check(&weights.config.plan().unwrap()).unwrap();
    assert_eq!(weights.arrays(), Weights::random(&weights.config, 7).unwrap().arrays());

    let bytes = std::fs::read(reference("state_dict.pt")).unwrap();
    let saved = StateDict::parse(&bytes).unwrap().weights(&weights.config).unwrap();
    assert_eq!(saved.arrays(), weights.arrays());
    // A state dict does not name its network, and this network has no name.
    let error = Weights::read(&reference("state_dict.pt")).unwrap_err().to_string();
    assert!(
        error.contains("state_dict.pt: its 20 tensors are of none of the networks wnet-paper"),
        "{error}"
    );
}

#[test]
fn checkpoints_of_pytorch_are_read() {
    let weights = Weights::read(&reference("state_dict.safetensors")).unwrap();
    let bytes = std::fs::read(reference("checkpoint.pt")).unwrap();
    let saved = StateDict::parse(&bytes).unwrap().weights(&weights.config).unwrap();
    let roundings: [fn(f32) -> f32; 3] =
        [|v| v, |v| f16::from_f32(v).to_f32(), |v| bf16::from_f32(v).to_f32()];
    let mut rounded = [0; 3];
    for (name, array) in weights.arrays() {
        let found = &saved.arrays()[name];
        let is_rounding = |round: &fn(f32) -> f32| {
            found.shape == array.shape
                && array.values.iter().map(|&v| round(v)).eq(found.values.iter().copied())
        };
        let rounding = roundings.iter().position(is_rounding);
        rounded[rounding.unwrap_or_else(|| panic!("{name}: {:?}", found.values))] += 1;
    }
    assert_eq!(rounded, [13, 5, 2]);
}
