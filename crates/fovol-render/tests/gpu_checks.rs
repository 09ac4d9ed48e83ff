//! Frames with every check of wgpu, and with none.
//!
//! These tests need an adapter, a software one included: `cargo test --workspace -- --ignored`.
#![cfg(feature = "gpu")]

mod scenes;

use fovol_core::{Fovea, Frame, FrameSize, Integration, Scene};
use fovol_gpu::{AdapterRequest, Checks, Gpu};
use fovol_render::gpu::{MarchStrategy, MaskSource, Renderer, Sampling};
use fovol_render::noise::{Noise, NoiseKind};
use scenes::{cameras, differences, transfer, volumes};
use std::sync::Arc;

/// Frames of every way to sample and to march, on a device with these checks.
fn frames(checks: Checks) -> Vec<Frame> {
    let gpu = Gpu::open_with(&AdapterRequest::Any.or_environment(), checks).unwrap();
    let (_, volume) = volumes().remove(0);
    let mut scene = Scene::new(Arc::new(volume), transfer());
    let size = FrameSize::new(61, 43).unwrap();
    let noise = Noise::new(NoiseKind::Stbn, 1);
    let fovea = Fovea { base: 0.2, sigma: 0.1, gaze: [0.4, 0.6] };
    let mut renderer = Renderer::new(&gpu, &scene).unwrap();
    let mut buffers = renderer.frame_buffers(size).unwrap();
    let mut frames = Vec::new();
    // Compiling takes most of the time: fine integration is tried with fewer strategies.
    for (integration, every) in [(Integration::Plain, 2), (Integration::Fine, 4)] {
        scene.integration = integration;
        renderer.set_scene(&scene).unwrap();
        for strategy in MarchStrategy::candidates().step_by(every) {
            renderer.set_march_strategy(strategy);
            for sampling in [
                Sampling::Full,
                Sampling::Reject(MaskSource { fovea: &fovea, noise: &noise, frame: 3 }),
                Sampling::Compact(MaskSource { fovea: &fovea, noise: &noise, frame: 3 }),
            ] {
                renderer.render(&mut buffers, &cameras()[0], sampling).unwrap();
                frames.push(buffers.read_frame().unwrap());
            }
        }
    }
    frames
}

#[test]
#[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
fn frames_are_the_same_with_every_check_and_with_none() {
    let expected = frames(Checks::ALL);
    assert!(expected.iter().any(|frame| frame.pixels().iter().any(|pixel| pixel[0] > 0.1)));
    for (number, (frame, expected)) in frames(Checks::NONE).iter().zip(&expected).enumerate() {
        // Compilers may round some products and sums together in one shader and not in the other.
        let (.., most, mean) = differences(frame, expected);
        assert!(most <= 1e-6, "frame {number}: {most} {mean}");
    }
}
