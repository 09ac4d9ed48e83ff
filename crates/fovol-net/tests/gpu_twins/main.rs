//! Compares the GPU engine with the CPU engine in f32.
//!
//! These tests need an adapter; a software rasteriser suffices: `cargo test --workspace -- --ignored`. On Debian
//! `apt-get install mesa-vulkan-drivers libvulkan1` installs one. It uses all processors for each test, so one test
//! at a time (`--test-threads 1`) is faster.
#![cfg(feature = "gpu")]

#[path = "../cases/mod.rs"]
mod cases;
mod halves;

use cases::{Case, cases, difference, frame};
use fovol_core::{Frame, FrameSize, SparseFrame};
use fovol_gpu::{AdapterRequest, Gpu, GpuError, read};
use fovol_net::gpu::{DeviceInput, FrameInput, Network, Precision, PullPush, State};
use fovol_net::plan::{
    Activation, Add, Conv, DepthToSpace, Filter, Join, Named, NetworkConfig, Norm, Normalisation, Part, Plan,
    PlanBuilder, Pool, Read, Scale, Smooth, SpaceToDepth, Taps, TensorId, Warp,
};
use fovol_net::weights::Array;
use fovol_net::{Error, Fill, Weights, cpu};
use proptest::prelude::*;
use std::sync::LazyLock;

static GPU: LazyLock<Gpu> = LazyLock::new(|| Gpu::open(&AdapterRequest::Any.or_environment()).unwrap());

/// Tolerance for pictures, relative to their largest value.
const TOLERANCE: f32 = 1e-4;

fn size(width: u32, height: u32) -> FrameSize {
    FrameSize::new(width, height).unwrap()
}

/// Pseudo-random number in 0…1.
fn random(seed: u64) -> f32 {
    let mixed = (seed ^ seed >> 29).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    ((mixed ^ mixed >> 32).wrapping_mul(0xBF58_476D_1CE4_E5B9) >> 40) as f32 / (1 << 24) as f32
}

/// Sparse frame of a moving pattern: one pixel in six, different ones in each frame, and some damaged values.
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

/// Random motion of pixels. Some of it leads out of the frame, and some is not finite.
fn motion(size: FrameSize, t: u32) -> Vec<[f32; 2]> {
    let pixel = |i: usize| match i % 53 {
        50 => [f32::NAN, 1.0],
        51 => [f32::NEG_INFINITY, 1e30],
        52 => [1e9, -3e9],
        _ => [0, 1].map(|axis| 6.0 * random(i as u64 / 7 + u64::from(t) * 1000 + axis) - 2.5),
    };
    (0..size.pixels()).map(pixel).collect()
}

/// Frames and motion of a sequence. Every third frame has no motion.
fn clip(size: FrameSize, frames: u32) -> Vec<(Frame, Option<Vec<[f32; 2]>>)> {
    (0..frames).map(|t| (sparse(size, t), (t % 3 != 2).then(|| motion(size, t)))).collect()
}

fn values(frame: &Frame) -> Vec<f32> {
    frame.pixels().iter().flatten().copied().collect()
}

/// Prepares the network of `plan` on the CPU and on `gpu`.
fn both(gpu: &Gpu, plan: &Plan, weights: &Weights) -> (cpu::Network, Network) {
    let exact = cpu::Precision::F32;
    let expected = cpu::Network::new(plan.clone(), weights, cpu::Simd::best(), exact).unwrap();
    (expected, Network::new(gpu, plan.clone(), weights, Precision::F32).unwrap())
}

/// Largest difference between both engines in any frame of a sequence.
fn worst(gpu: &Gpu, plan: &Plan, weights: &Weights, size: FrameSize, frames: u32) -> f32 {
    let (specification, network) = both(gpu, plan, weights);
    let (mut expected_state, mut state) = (specification.state(size), network.state(size).unwrap());
    let difference = |(sparse, motion): &(Frame, Option<Vec<[f32; 2]>>)| {
        let input = FrameInput { sparse: &SparseFrame::from(sparse), motion: motion.as_deref() };
        let expected = specification.reconstruct(&input, &mut expected_state).unwrap();
        let found = network.reconstruct(&input, &mut state).unwrap();
        difference(&values(&found), &values(&expected))
    };
    clip(size, frames).iter().map(difference).fold(0.0, f32::max)
}

#[test]
#[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
fn networks_are_those_of_the_cpu() {
    for named in Named::ALL {
        let config = named.config();
        let weights = Weights::random(&config, 4).unwrap();
        for (size, frames) in [(size(37, 23), 4), (size(1, 1), 2)] {
            let worst = worst(&GPU, &config.plan().unwrap(), &weights, size, frames);
            println!("{named} {size}: {worst:.1e}");
            assert!(worst <= TOLERANCE, "{named} {size}: {worst}");
        }
    }
}

#[test]
#[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
fn networks_agree_with_pytorch() {
    for path in cases() {
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        // Cases that differ from others only in size or seed are skipped, as they are slow in software.
        if name.ends_with("64x40") || name.ends_with("seed8") {
            continue;
        }
        let case = Case::read(&path);
        let size = size(case.number("width"), case.number("height"));
        let config: NetworkConfig = serde_json::from_str(&case.facts["config"]).unwrap();
        let weights = Weights::random(&config, u64::from(case.number("seed"))).unwrap();
        let network = Network::new(&GPU, config.plan().unwrap(), &weights, Precision::F32).unwrap();
        let mut state = network.state(size).unwrap();
        let mut worst = 0.0f32;
        for t in 0..case.number("frames") {
            let values = |name: &str| case.values(&format!("{name}.{t}"));
            let sparse = SparseFrame::from(&frame(size, &values("input").unwrap(), &values("mask").unwrap()));
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

/// Random weights of `plan`. Their configuration is arbitrary and not used.
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

/// Builds a plan of layers and combinations that no named network has.
fn unusual_plan(normalisation: Normalisation) -> Plan {
    let mut b = PlanBuilder::new();
    let (colour, mask) = (b.colour(), b.mask());
    let (late, later, seen) = (b.state("late", 3, 0), b.state("later", 3, 0), b.state("seen", 3, 0));
    let folded = b.add(SpaceToDepth::new(colour));
    let folded = b.add(Scale::new(folded, 0.5, 0.25));
    let unfolded = b.add(DepthToSpace::new(folded));
    let smooth = b.add(Smooth::new(unfolded));
    let joined = b.add(Join::new(smooth, mask));
    let half = b.add(Pool::new(joined));
    let motion = b.motion();
    let warped = b.add(Warp::new(half, motion));
    let part = b.add(Part::new(joined, 1, 3));
    let some = b.add(Part::new(joined, 2, 2));
    let read = [Read::nearest(warped), Read::same(some), Read::same(seen), Read::same(late)];
    let wide = b.add(Conv::new("wide", &read, 21, 3, Activation::Elu));
    let wide = b.add(Norm::new("norm", wide, Activation::Relu));
    let wider =
        b.add(Conv::replicating("wider", &[Read::same(wide), Read::same(later)], 35, 2, Activation::None));
    let deep = b.add(Conv::replicating("deep", &[Read::same(wider)], 18, 2, Activation::Relu));
    let deep = b.add(Pool::new(deep));
    let up = b.add(Conv::new("up", &[Read::bilinear(deep)], 5, 1, Activation::None));
    let up = b.add(Conv::new("upper", &[Read::nearest(up), Read::same(wider)], 9, 3, Activation::Elu));
    let small = b.add(Conv::new("small", &[Read::same(up)], 3, 1, Activation::None));
    let picture = kernel(&mut b, "kernel", 1, wide, &[(Read::same(part), Taps::Around)], normalisation);
    let images = [
        (Read::same(picture), Taps::Centre),
        (Read::nearest(small), Taps::Around),
        (Read::same(late), Taps::Centre),
        (Read::bilinear(small), Taps::Around),
    ];
    let filtered = kernel(&mut b, "four", 2, up, &images, normalisation);
    let sum = b.add(Add::new(filtered, smooth));
    let out = b.add(Scale::new(sum, 0.4, 0.2));
    // A chain of delayed states, and a state that is the input.
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
    let (name, images, output) = (name.to_owned(), images.to_vec(), TensorId::UNSET);
    b.add(Filter { name, features, expand, images, output, normalisation })
}

#[test]
#[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
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

#[test]
#[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
fn frames_are_normalised_as_a_whole() {
    // More elements than all threads read at once, and an incomplete last block.
    let mut b = PlanBuilder::new();
    let wide = b.add(Conv::new("wide", &[Read::same(b.colour())], 21, 1, Activation::Elu));
    let normal = b.add(Norm::new("norm", wide, Activation::None));
    let picture = b.add(Conv::new("picture", &[Read::same(normal)], 3, 1, Activation::Relu));
    let plan = b.finish(picture);
    let worst = worst(&GPU, &plan, &random_weights(&plan), size(210, 130), 1);
    assert!(worst <= TOLERANCE, "{worst}");
}

#[test]
#[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
fn infinity_does_not_stay() {
    // The state is 1, then −1e38, then overflows f32 and starts again.
    let mut b = PlanBuilder::new();
    let before = b.state("before", 3, 0);
    let next = b.add(Scale::new(before, -1e38, 1.0));
    b.keep(before, next);
    let plan = b.finish(next);
    assert_eq!(worst(&GPU, &plan, &random_weights(&plan), size(9, 5), 6), 0.0);
}

/// A small network, and a function that makes states for it.
fn fast(precision: Precision) -> (Network, impl Fn(FrameSize) -> State) {
    let weights = Weights::random(&Named::WNetFast.config(), 1).unwrap();
    let network = Network::new(&GPU, weights.config.plan().unwrap(), &weights, precision).unwrap();
    let clone = network.clone();
    (network, move |size| clone.state(size).unwrap())
}

#[test]
#[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
fn states_are_independent_and_start_anew() {
    let size = size(21, 34);
    let (network, state) = fast(Precision::F16);
    let clip = clip(size, 3);
    let run = |state: &mut State, t: usize| {
        let (sparse, motion) = &clip[t];
        let input = FrameInput { sparse: &SparseFrame::from(sparse), motion: motion.as_deref() };
        network.reconstruct(&input, state).unwrap()
    };
    let mut alone = state(size);
    let expected: Vec<Frame> = (0..3).map(|t| run(&mut alone, t)).collect();
    let (mut left, mut right) = (state(size), state(size));
    let mut found = vec![run(&mut left, 0)];
    run(&mut right, 2);
    found.push(run(&mut left, 1));
    run(&mut right, 1);
    found.push(run(&mut left, 2));
    assert_eq!(found, expected);
    assert_ne!(run(&mut left, 0), expected[0], "without memory this proves nothing");
    // Resets after an odd and after an even number of frames.
    for _ in 0..2 {
        left.reset();
        assert_eq!(run(&mut left, 0), expected[0]);
        run(&mut left, 1);
    }
}

/// Uploads `values` to a buffer.
fn uploaded<T: bytemuck::Pod>(values: &[T]) -> wgpu::Buffer {
    let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST;
    let buffer = GPU.buffer("input", size_of_val(values) as u64, usage);
    GPU.queue().write_buffer(&buffer, 0, bytemuck::cast_slice(values));
    buffer
}

#[test]
#[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
fn frames_of_the_device_need_no_host() {
    let size = size(30, 19);
    let (network, state) = fast(Precision::F32);
    let clip = clip(size, 4);
    let (mut expected_state, mut state) = (state(size), state(size));
    state.set_timed(true);
    let mut encoder = GPU.device().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let mut expected = Frame::new(size);
    for (sparse, motion) in &clip {
        let input = FrameInput { sparse: &SparseFrame::from(sparse), motion: motion.as_deref() };
        expected = network.reconstruct(&input, &mut expected_state).unwrap();
        let (sparse, motion) = (uploaded(sparse.pixels()), motion.as_deref().map(uploaded));
        let input = DeviceInput { sparse: &sparse, motion: motion.as_ref() };
        network.encode(&mut encoder, input, &mut state).unwrap();
    }
    GPU.enqueue([encoder.finish()]);
    assert_eq!(state.read_frame().unwrap(), expected);
    let pixels: Vec<[f32; 4]> = read(&GPU, state.frame_buffer(), size.pixels()).unwrap();
    assert_eq!(pixels, expected.pixels());
    if let Some(times) = state.read_times().unwrap() {
        let names: Vec<&str> = times.iter().map(|time| time.name.as_str()).collect();
        assert_eq!(names[0], "input");
        assert!(["encoder.0.conv1", "spread", "add"].iter().all(|name| names.contains(name)), "{names:?}");
        assert!(times.iter().all(|time| time.ms >= 0.0));
    }
    assert!(expected_state.read_times().unwrap().is_none());
}

#[test]
#[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
fn what_does_not_fit_is_an_error() {
    let (ours, state) = fast(Precision::F32);
    let (_, other_state) = fast(Precision::F32);
    let (small, large) = (size(20, 10), size(21, 10));
    let frame = Frame::new(small);
    let none = SparseFrame::from(&frame);
    let input = FrameInput { sparse: &none, motion: None };
    let error = ours.reconstruct(&input, &mut other_state(small)).unwrap_err().to_string();
    assert!(error.contains("another network"), "{error}");
    let error = ours.reconstruct(&input, &mut state(large)).unwrap_err().to_string();
    assert!(error.contains("21x10, not 20x10"), "{error}");
    let short = FrameInput { sparse: &none, motion: Some(&[[0.0; 2]; 3]) };
    assert!(ours.reconstruct(&short, &mut state(small)).is_err());

    let mut encoder = GPU.device().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let sparse = uploaded(frame.pixels());
    let input = DeviceInput { sparse: &sparse, motion: None };
    let error = ours.encode(&mut encoder, input, &mut state(large)).unwrap_err().to_string();
    assert!(error.contains("3200 bytes, not 3360"), "{error}");

    // Five input tensors are more than a shader can bind.
    let mut b = PlanBuilder::new();
    let five = [Read::same(b.colour()); 5];
    let out = b.add(Conv::new("five", &five, 3, 1, Activation::None));
    let plan = b.finish(out);
    let error = Network::new(&GPU, plan.clone(), &random_weights(&plan), Precision::F32).unwrap_err();
    assert!(error.to_string().contains("`five` reads 5 tensors"), "{error}");
    let wrong = Weights::random(&Named::WNetPaper.config(), 1).unwrap();
    assert!(Network::new(&GPU, plan, &wrong, Precision::F32).is_err());
}

#[test]
#[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
fn any_webgpu_is_enough_and_too_large_frames_are_refused() {
    let gpu = Gpu::open_baseline(&AdapterRequest::Any.or_environment()).unwrap();
    for named in [Named::WNetFast, Named::DeepFoveaOrig] {
        let config = named.config();
        let weights = Weights::random(&config, 9).unwrap();
        let plan = config.plan().unwrap();
        let worst = worst(&gpu, &plan, &weights, size(19, 18), 2);
        assert!(worst <= TOLERANCE, "{named}: {worst}");
        for precision in [Precision::F16, Precision::Auto] {
            let network = Network::new(&gpu, plan.clone(), &weights, precision).unwrap();
            assert_ne!(network.precision(), Precision::Auto);
            let frame = SparseFrame::from(&sparse(size(19, 18), 0));
            let input = FrameInput { sparse: &frame, motion: None };
            network.reconstruct(&input, &mut network.state(frame.size()).unwrap()).unwrap();
        }
        let network = Network::new(&gpu, plan, &weights, Precision::F32).unwrap();
        let Err(Error::Gpu(GpuError::Limit { what, limit, .. })) = network.state(size(9000, 9000)) else {
            panic!("{named}")
        };
        assert!(what.contains("frame") && limit == "maxStorageBufferBindingSize", "{what} {limit}");
    }
}

#[test]
#[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
fn memory_is_shared_by_tensors_that_are_not_needed_at_once() {
    let (network, state) = fast(Precision::F32);
    let size = size(64, 64);
    let tensors = network.plan().tensors().iter();
    let apart = tensors.map(|t| 16 * (size.pixels() as u64 >> (2 * t.level)) * t.channels.div_ceil(4) as u64);
    let shared = state(size).bytes();
    assert!(3 * shared < 2 * apart.sum::<u64>(), "{shared}");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, failure_persistence: None, ..Default::default() })]
    #[test]
    #[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
    fn filled_frames_are_those_of_the_cpu(w in 1u32..70, h in 1u32..50, seed in 0u64..1000, density in 0u32..60) {
        let size = size(w, h);
        let mut frame = Frame::new(size);
        for (i, pixel) in frame.pixels_mut().iter_mut().enumerate() {
            let number = |k: u64| random((seed << 32) + 5 * i as u64 + k);
            let is_sampled = number(0) * 100.0 < density as f32;
            *pixel = if is_sampled { [number(1), number(2), 30.0 * number(3), 1.0] } else { [0.0; 4] };
        }
        let frame = SparseFrame::from(&frame);
        let expected = Fill::PullPush.reconstruct(&frame);
        let found = PullPush::new(&GPU, size).unwrap().reconstruct(&frame).unwrap();
        for (found, expected) in values(&found).iter().zip(values(&expected)) {
            prop_assert!((found - expected).abs() <= 1e-5 * expected.abs().max(1.0), "{found} {expected}");
        }
    }
}
