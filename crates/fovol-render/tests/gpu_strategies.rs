//! Strategies of marching on a GPU: the bytes of one thread a ray.
//!
//! These tests need an adapter, a software one included: `cargo test --workspace -- --ignored`.
#![cfg(feature = "gpu")]

mod gpu_frames;
mod scenes;

use fovol_core::{FrameSize, Pixel, SampleList, Scene, ShadowMode, SurfaceShading};
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

#[test]
#[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
fn every_way_to_march_gives_the_same_bytes() {
    let size = FrameSize::new(45, 37).unwrap();
    for (name, volume) in volumes() {
        let mut scene = Scene::new(Arc::new(volume), transfer());
        scene.background = [0.1, 0.2, 0.3];
        let mut renderer = Renderer::new(&GPU, &scene).unwrap();
        let mut buffers = renderer.frame_buffers(size).unwrap();
        for shadows in [ShadowMode::On, ShadowMode::Off, ShadowMode::Cached] {
            for surface in [SurfaceShading::Flat, SurfaceShading::Gradient] {
                (scene.shading.shadows, scene.shading.surface) = (shadows, surface);
                renderer.set_scene(&scene).unwrap();
                for camera in cameras() {
                    renderer.set_march_strategy(MarchStrategy::Rays);
                    let expected = full_frame(&renderer, &mut buffers, &camera);
                    let depths = buffers.read_inverse_depths().unwrap();
                    for strategy in strategies() {
                        renderer.set_march_strategy(strategy);
                        let what = format!("{name} {shadows:?} {surface:?} {strategy:?}");
                        let frame = full_frame(&renderer, &mut buffers, &camera);
                        assert!(frame == expected, "{what}: {:?}", differences(&frame, &expected));
                        assert_eq!(buffers.read_inverse_depths().unwrap(), depths, "{what}");
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
