//! The GPU against the engine of the CPU in f32.
//!
//! These tests need an adapter, a software one included: `cargo test --features gpu -- --include-ignored`. On Debian
//! `apt-get install mesa-vulkan-drivers libvulkan1` is one.
#![cfg(feature = "gpu")]

mod cases;

use cases::{Case, cases, difference, frame};
use fovol_core::{Frame, FrameSize};
use fovol_gpu::{AdapterRequest, Gpu, GpuError, read};
use fovol_net::gpu::{DeviceInput, FrameInput, Network, Precision, PullPush, State};
use fovol_net::plan::{
    Activation, Filter, Named, NetworkConfig, Normalisation, Plan, PlanBuilder, Read, Taps, TensorId,
};
use fovol_net::weights::Array;
use fovol_net::{Error, Fill, Weights, cpu};
use proptest::prelude::*;
use std::sync::LazyLock;

static GPU: LazyLock<Gpu> = LazyLock::new(|| Gpu::open(&AdapterRequest::Any.or_environment()).unwrap());

/// How far pictures may be off, of their largest value.
const TOLERANCE: f32 = 1e-4;

fn size(width: u32, height: u32) -> FrameSize {
    FrameSize::new(width, height).unwrap()
}

/// A number in 0…1 that looks random.
fn random(seed: u64) -> f32 {
    let mixed = (seed ^ seed >> 29).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    ((mixed ^ mixed >> 32).wrapping_mul(0xBF58_476D_1CE4_E5B9) >> 40) as f32 / (1 << 24) as f32
}

/// A sparse frame of a moving pattern: one pixel of six, other ones in each frame; some are damaged.
fn sparse(size: FrameSize, t: u32) -> Frame {
    let mut frame = Frame::new(size);
    for (i, pixel) in frame.pixels_mut().iter_mut().enumerate() {
        let (x, y) = (i as u32 % size.width, i as u32 / size.width);
        if (x * 7 + y * 3 + t * 5).is_multiple_of(6) {
            let wave = |f: f32| 0.4 + 0.35 * ((x + 2 * t) as f32 * f + y as f32 * 0.07).sin();
            *pixel = [wave(0.09), wave(0.17), wave(0.05), 1.0];
        }
        match i % 97 {
            60 => *pixel = [f32::NAN, 0.5, 0.5, 1.0],
            61 => *pixel = [0.5, f32::INFINITY, 1e38, 1.0],
            62 => *pixel = [-0.5, 7.0, 0.5, 1.0],
            _ => {}
        }
    }
    frame
}

/// Motion of some pixels, some of it out of the frame, and some of it no number.
fn motion(size: FrameSize, t: u32) -> Vec<[f32; 2]> {
    let pixel = |i: usize| match i % 53 {
        50 => [f32::NAN, 1.0],
        51 => [f32::NEG_INFINITY, 1e30],
        52 => [1e9, -3e9],
        _ => [0, 1].map(|axis| 6.0 * random(i as u64 / 7 + u64::from(t) * 1000 + axis) - 2.5),
    };
    (0..size.pixels()).map(pixel).collect()
}

/// Frames and motion of a clip; every third frame stands still.
fn clip(size: FrameSize, frames: u32) -> Vec<(Frame, Option<Vec<[f32; 2]>>)> {
    (0..frames).map(|t| (sparse(size, t), (t % 3 != 2).then(|| motion(size, t)))).collect()
}

fn values(frame: &Frame) -> Vec<f32> {
    frame.pixels().iter().flatten().copied().collect()
}

/// The networks of `plan` on the CPU and on `gpu`.
fn both(gpu: &Gpu, plan: &Plan, weights: &Weights) -> (cpu::Network, Network) {
    let exact = cpu::Precision::F32;
    let expected = cpu::Network::new(plan.clone(), weights, cpu::Simd::best(), exact).unwrap();
    (expected, Network::new(gpu, plan.clone(), weights, Precision::F32).unwrap())
}

/// The largest difference between both engines in any frame of a clip.
fn worst(gpu: &Gpu, plan: &Plan, weights: &Weights, size: FrameSize, frames: u32) -> f32 {
    let (specification, network) = both(gpu, plan, weights);
    let (mut expected_state, mut state) = (specification.state(size), network.state(size).unwrap());
    let difference = |(sparse, motion): &(Frame, Option<Vec<[f32; 2]>>)| {
        let input = FrameInput { sparse, motion: motion.as_deref() };
        let expected = specification.reconstruct(&input, &mut expected_state).unwrap();
        let found = network.reconstruct(&input, &mut state).unwrap();
        difference(&values(&found), &values(&expected))
    };
    clip(size, frames).iter().map(difference).fold(0.0, f32::max)
}

#[test]
#[ignore = "needs an adapter: cargo test --features gpu -- --include-ignored"]
fn networks_are_those_of_the_cpu() {
    for named in Named::ALL {
        let config = named.config();
        let weights = Weights::random(&config, 4).unwrap();
        for (size, frames) in [(size(37, 23), 4), (size(1, 1), 3), (size(16, 50), 2)] {
            let worst = worst(&GPU, &config.plan().unwrap(), &weights, size, frames);
            println!("{named} {size}: {worst:.1e}");
            assert!(worst <= TOLERANCE, "{named} {size}: {worst}");
        }
    }
}

#[test]
#[ignore = "needs an adapter: cargo test --features gpu -- --include-ignored"]
fn networks_agree_with_pytorch() {
    for path in cases() {
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        let case = Case::read(&path);
        let size = size(case.number("width"), case.number("height"));
        let config: NetworkConfig = serde_json::from_str(&case.facts["config"]).unwrap();
        let weights = Weights::random(&config, u64::from(case.number("seed"))).unwrap();
        let network = Network::new(&GPU, config.plan().unwrap(), &weights, Precision::F32).unwrap();
        let mut state = network.state(size).unwrap();
        let mut worst = 0.0f32;
        for t in 0..case.number("frames") {
            let values = |name: &str| case.values(&format!("{name}.{t}"));
            let sparse = frame(size, &values("input").unwrap(), &values("mask").unwrap());
            let n = size.pixels();
            let pairs = |planes: Vec<f32>| (0..n).map(|i| [planes[i], planes[n + i]]).collect::<Vec<_>>();
            let motion = values("motion").map(pairs);
            let input = FrameInput { sparse: &sparse, motion: motion.as_deref() };
            let out = network.reconstruct(&input, &mut state).unwrap();
            let planes: Vec<f32> = (0..3).flat_map(|c| out.pixels().iter().map(move |p| p[c])).collect();
            worst = worst.max(difference(&planes, &values("output").unwrap()));
        }
        println!("{name}: {worst:.1e}");
        assert!(worst <= TOLERANCE, "{name}: {worst}");
    }
}

/// Random weights of `plan`; what configuration they are of is not looked at.
fn random_weights(plan: &Plan) -> Weights {
    let array = |(number, parameter): (usize, fovol_net::plan::Parameter)| {
        let reach = 1.5 / (parameter.len() as f32 / parameter.shape[0] as f32).sqrt();
        let value = |i: usize| reach * (2.0 * random((number * 100_000 + i) as u64) - 1.0);
        let values = (0..parameter.len()).map(value).collect();
        (parameter.name, Array { shape: parameter.shape, values })
    };
    let arrays = plan.parameters().into_iter().enumerate().map(array).collect();
    Weights::new(Named::WNetFast.config(), arrays)
}

/// Layers, and ways to read and to keep, that no named network has.
fn unusual_plan(normalisation: Normalisation) -> Plan {
    let mut b = PlanBuilder::new();
    let (colour, mask) = (b.colour(), b.mask());
    let (late, later, seen) = (b.state("late", 3, 0), b.state("later", 3, 0), b.state("seen", 3, 0));
    let folded = b.space_to_depth(colour);
    let folded = b.scale(folded, 0.5, 0.25);
    let unfolded = b.depth_to_space(folded);
    let smooth = b.smooth(unfolded);
    let joined = b.join(smooth, mask);
    let half = b.pool(joined);
    let warped = b.warp(half);
    let part = b.part(joined, 1, 3);
    let some = b.part(joined, 2, 2);
    let read = [Read::nearest(warped), Read::same(some), Read::same(seen), Read::same(late)];
    let wide = b.conv("wide", &read, 21, 3, Activation::Elu);
    let wide = b.norm("norm", wide, Activation::Relu);
    let wider = b.replicating_conv("wider", &[Read::same(wide), Read::same(later)], 35, 2, Activation::None);
    let deep = b.replicating_conv("deep", &[Read::same(wider)], 18, 2, Activation::Relu);
    let deep = b.pool(deep);
    let up = b.conv("up", &[Read::bilinear(deep)], 5, 1, Activation::None);
    let up = b.conv("upper", &[Read::nearest(up), Read::same(wider)], 9, 3, Activation::Elu);
    let small = b.conv("small", &[Read::same(up)], 3, 1, Activation::None);
    let picture = kernel(&mut b, "kernel", 1, wide, &[(Read::same(part), Taps::Around)], normalisation);
    let images = [
        (Read::same(picture), Taps::Centre),
        (Read::nearest(small), Taps::Around),
        (Read::same(late), Taps::Centre),
        (Read::bilinear(small), Taps::Around),
    ];
    let filtered = kernel(&mut b, "four", 2, up, &images, normalisation);
    let sum = b.add(filtered, smooth);
    let out = b.scale(sum, 0.4, 0.2);
    // A line of delays, and what comes in.
    b.keep(late, out);
    b.keep(later, late);
    b.keep(seen, colour);
    b.finish(out)
}

fn kernel(
    b: &mut PlanBuilder,
    name: &str,
    expand: usize,
    features: TensorId,
    images: &[(Read, Taps)],
    normalisation: Normalisation,
) -> TensorId {
    let (name, images, output) = (name.to_owned(), images.to_vec(), features);
    b.filter(Filter { name, features, expand, images, output, normalisation })
}

#[test]
#[ignore = "needs an adapter: cargo test --features gpu -- --include-ignored"]
fn unusual_layers_are_those_of_the_cpu() {
    for normalisation in [Normalisation::Squared, Normalisation::Softmax] {
        let plan = unusual_plan(normalisation);
        let weights = random_weights(&plan);
        for size in [size(41, 27), size(3, 9)] {
            let worst = worst(&GPU, &plan, &weights, size, 5);
            println!("{normalisation:?} {size}: {worst:.1e}");
            assert!(worst <= TOLERANCE, "{normalisation:?} {size}: {worst}");
        }
    }
}
