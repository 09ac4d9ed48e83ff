//! Strategies of marching on a GPU: the numbers of one thread a ray.
//!
//! These tests need an adapter, a software one included: `cargo test --workspace -- --ignored`.
#![cfg(feature = "gpu")]

mod gpu_frames;
mod scenes;

use fovol_core::{FrameSize, Integration, Pixel, SampleList, Scene, ShadowMode, SurfaceShading};
use fovol_gpu::Choices;
use fovol_render::gpu::{MarchStrategy, Pool, Renderer, Sampling};
use gpu_frames::{GPU, full_frame, small_scene};
use scenes::{cameras, differences, transfer, volumes};
use std::sync::Arc;

/// Strategies of marching, among them queues that are full after every stretch.
fn strategies() -> impl Iterator<Item = MarchStrategy> {
    let full_queues = [(1, 32, 32), (4, 128, 32), (16, 64, 5)];
    let pools = full_queues.map(|(rays, threads, queue)| Pool::with_queue(rays, threads, queue).unwrap());
    MarchStrategy::candidates().chain(pools.map(MarchStrategy::Pool))
}

/// Largest difference that rounding may make. With fine integration compilers may round some products and sums together in
/// one shader and not in the other.
fn rounding(integration: Integration) -> f32 {
    match integration {
        Integration::Plain => 0.0,
        Integration::Fine => 1e-6,
    }
}

#[test]
#[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
fn every_way_to_march_gives_the_same_bytes() {
    check_every_way(Integration::Plain);
}

#[test]
#[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
fn every_way_to_march_finely_gives_the_same_numbers() {
    check_every_way(Integration::Fine);
}

fn check_every_way(integration: Integration) {
    let size = FrameSize::new(45, 37).unwrap();
    for (name, volume) in volumes() {
        let mut scene = Scene::new(Arc::new(volume), transfer());
        scene.background = [0.1, 0.2, 0.3];
        let mut renderer = Renderer::new(&GPU, &scene).unwrap();
        let mut buffers = renderer.frame_buffers(size).unwrap();
        for shadows in [ShadowMode::On, ShadowMode::Off, ShadowMode::Cached] {
            for surface in [SurfaceShading::Flat, SurfaceShading::Gradient] {
                (scene.shading.shadows, scene.shading.surface) = (shadows, surface);
                scene.integration = integration;
                renderer.set_scene(&scene).unwrap();
                for camera in cameras() {
                    renderer.set_march_strategy(MarchStrategy::Rays);
                    let expected = full_frame(&renderer, &mut buffers, &camera);
                    let depths = buffers.read_inverse_depths().unwrap();
                    // Compiling takes most of the time: fine integration with gradients is tried with some pools.
                    let some = integration == Integration::Fine && surface == SurfaceShading::Gradient;
                    for strategy in strategies().step_by(if some { 3 } else { 1 }) {
                        renderer.set_march_strategy(strategy);
                        let what = format!("{name} {integration:?} {shadows:?} {surface:?} {strategy:?}");
                        let frame = full_frame(&renderer, &mut buffers, &camera);
                        let (.., most, mean) = differences(&frame, &expected);
                        assert!(most <= rounding(integration), "{what}: {most} {mean}");
                        let found = buffers.read_inverse_depths().unwrap();
                        let near = |(a, b): (&f32, &f32)| (a - b).abs() <= rounding(integration) * b.abs();
                        assert!(found.iter().zip(&depths).all(near), "{what}");
                    }
                }
            }
        }
    }
}

#[test]
#[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
fn lists_of_every_length_are_marched_alike() {
    let size = FrameSize::new(61, 43).unwrap();
    let mut renderer = Renderer::new(&GPU, &small_scene()).unwrap();
    let mut buffers = renderer.frame_buffers(size).unwrap();
    let camera = cameras()[0];
    for length in [0usize, 1, 3, 4, 5, 15, 16, 17, 63, 64, 65, 127, 128, 129, 1000] {
        let pixel = |i: usize| Pixel { x: (i * 17 % 61) as u16, y: (i * 29 % 43) as u16 };
        let list = SampleList::new(size, (0..length).map(pixel).collect());
        renderer.set_march_strategy(MarchStrategy::Rays);
        renderer.render(&mut buffers, &camera, Sampling::List(&list)).unwrap();
        let expected = buffers.read_frame().unwrap();
        for strategy in strategies() {
            renderer.set_march_strategy(strategy);
            renderer.render(&mut buffers, &camera, Sampling::List(&list)).unwrap();
            assert_eq!(buffers.read_frame().unwrap(), expected, "{length} pixels, {strategy:?}");
        }
    }
}

#[test]
#[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
fn tuning_tries_every_way_and_keeps_one() {
    let mut renderer = Renderer::new(&GPU, &small_scene()).unwrap();
    let mut buffers = renderer.frame_buffers(FrameSize::new(45, 37).unwrap()).unwrap();
    let camera = cameras()[0];
    renderer.set_march_strategy(MarchStrategy::Rays);
    let expected = full_frame(&renderer, &mut buffers, &camera);
    assert_eq!(buffers.played_march(), None);
    renderer.tune_marching(Choices::default());
    let mut all = Vec::new();
    for number in 0..40 {
        let (.., most, _) = differences(&full_frame(&renderer, &mut buffers, &camera), &expected);
        assert!(most <= rounding(small_scene().integration), "{number}: {most}");
        let played = buffers.played_march().unwrap();
        if !all.contains(&played) {
            all.push(played);
        }
        // The second way is the quickest.
        let ms = if all.get(1) == Some(&played) { 1.0 } else { 1.5 };
        renderer.learn_march_time(played, ms);
    }
    assert_eq!(all.len(), MarchStrategy::candidates().count());
    assert_eq!(buffers.played_march(), Some(all[1]));
}
