//! Parts of volumes, and NaN, on the GPU against the specification.
//!
//! These tests need an adapter, as those of `gpu_twins.rs`.
#![cfg(feature = "gpu")]

mod gaps;
mod scenes;

use fovol_core::{ClipBox, Frame, FrameSize, Integration, Scene, ShadowMode, SurfaceShading};
use fovol_gpu::{AdapterRequest, Gpu};
use fovol_render::Filtering;
use fovol_render::cpu::{self, RenderOptions, Simd};
use fovol_render::gpu::{Renderer, Sampling};
use glam::DVec3;
use scenes::{cameras, differences, transfer, volumes};
use std::sync::{Arc, LazyLock};

static GPU: LazyLock<Gpu> = LazyLock::new(|| Gpu::open(&AdapterRequest::Any.or_environment()).unwrap());

const SIZE: FrameSize = FrameSize { width: 93, height: 61 };

/// Pictures of `scene` from every camera, of the GPU and of the specification, in every kind of light.
fn pictures(mut scene: Scene, filtering: Filtering) -> Vec<(String, Frame, Frame)> {
    let mut renderer = Renderer::with_filtering(&GPU, &scene, filtering).unwrap();
    let scalar = RenderOptions { simd: Simd::Scalar, skip_empty: false };
    let mut specification = cpu::Renderer::new(&scene, scalar).unwrap();
    let mut buffers = renderer.frame_buffers(SIZE).unwrap();
    scene.background = [0.1, 0.2, 0.3];
    scene.shading.surface = SurfaceShading::Gradient;
    let mut pictures = Vec::new();
    for integration in [Integration::Plain, Integration::Fine] {
        for shadows in [ShadowMode::On, ShadowMode::Off, ShadowMode::Cached] {
            scene.integration = integration;
            scene.shading.shadows = shadows;
            renderer.set_scene(&scene).unwrap();
            specification.set_scene(&scene).unwrap();
            for (number, camera) in cameras().into_iter().enumerate() {
                let (expected, _) = specification.march_full(&camera, SIZE);
                for skip_empty in [false, true] {
                    renderer.set_skip_empty(skip_empty);
                    renderer.render(&mut buffers, &camera, Sampling::Full).unwrap();
                    let name = format!("{integration} {shadows:?} camera {number} skip {skip_empty}");
                    pictures.push((name, expected.clone(), buffers.read_frame().unwrap()));
                }
            }
        }
    }
    pictures
}

#[test]
#[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
fn parts_are_cut_where_the_specification_cuts_them() {
    for (name, volume) in volumes() {
        let [x, y, z] = volume.grid().dims().map(|dim| dim as f64);
        let (low, high) = (DVec3::new(0.21 * x, 0.0, 0.333 * z), DVec3::new(0.9 * x, 0.47 * y, 0.87 * z));
        let clip = ClipBox::new(low, high, volume.grid()).unwrap();
        let scene = Scene { clip: Some(clip), ..Scene::new(Arc::new(volume), transfer()) };
        for (picture, expected, found) in pictures(scene, Filtering::Exact) {
            let (p999, most, mean) = differences(&expected, &found);
            // A last sample at a face may fall either way.
            assert!(
                p999 <= 2.0 / 255.0 && most <= 8.0 / 255.0 && mean <= 2e-3,
                "{name} {picture}: {p999} {most} {mean}"
            );
        }
    }
}

#[test]
#[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
fn nan_looks_as_the_specification_says() {
    for nan in [[0.0; 4], [0.9, 0.1, 0.2, 0.4]] {
        let transfer = transfer().with_nan(nan).unwrap();
        let scene = Scene::new(Arc::new(gaps::volume()), transfer);
        for (picture, expected, found) in pictures(scene.clone(), Filtering::Exact) {
            let (p999, most, mean) = differences(&expected, &found);
            // A sample at the border of what NaN spoils may fall either way.
            assert!(
                p999 <= 2.0 / 255.0 && most <= 24.0 / 255.0 && mean <= 2e-3,
                "{nan:?} {picture}: {p999} {most} {mean}"
            );
        }
        for (picture, expected, found) in pictures(scene, Filtering::Hardware) {
            let (_, _, mean) = differences(&expected, &found);
            assert!(mean <= 4e-3, "{nan:?} filtered, {picture}: {mean}");
        }
    }
}
