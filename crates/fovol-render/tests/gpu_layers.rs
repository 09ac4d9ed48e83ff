//! Several volumes and voxels with colours on the GPU, against the specification.
//!
//! These tests need an adapter, as gpu_twins.rs says.
#![cfg(feature = "gpu")]

mod gaps;
mod gpu_frames;
mod layered;
mod scenes;

use fovol_core::{
    FrameSize, GradientOpacity, Integration, Interpolation, Layer, Scene, ShadowMode, SurfaceShading,
    TransferFunction,
};
use fovol_render::cpu::{self, RenderOptions, Simd};
use fovol_render::gpu::Renderer;
use gpu_frames::{GPU, full_frame, small_scene};
use scenes::{cameras, differences};

#[test]
#[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
fn pictures_are_those_of_the_specification() {
    for (name, mut scene) in layered::scenes() {
        for (shadows, surface) in [
            (ShadowMode::On, SurfaceShading::Gradient),
            (ShadowMode::Off, SurfaceShading::Flat),
            (ShadowMode::Cached, SurfaceShading::Flat),
        ] {
            scene.shading.shadows = shadows;
            scene.shading.surface = surface;
            agrees(&format!("{name} {shadows:?} {surface:?}"), &scene);
        }
    }
}

#[test]
#[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
fn projections_are_those_of_the_specification() {
    for (name, scene) in layered::projections() {
        agrees(&name, &scene);
    }
}

fn agrees(name: &str, scene: &Scene) {
    let size = FrameSize::new(93, 61).unwrap();
    let scalar = RenderOptions { simd: Simd::Scalar, skip_empty: false };
    let cpu = cpu::Renderer::new(scene, scalar).unwrap();
    let mut gpu = Renderer::new(&GPU, scene).unwrap();
    let mut buffers = gpu.frame_buffers(size).unwrap();
    // The processor multiplies the transmittances of volumes at voxels, each rounded to 8 bits. The device multiplies them along
    // columns of light, and interpolates and rounds once.
    let is_cached = scene.shading.shadows == ShadowMode::Cached;
    let [usual, rare] = if is_cached { [5.0, 12.0] } else { [2.0, 8.0] }.map(|levels| levels / 255.0);
    for camera in cameras() {
        let (expected, _) = cpu.march_full(&camera, size);
        for skip_empty in [false, true] {
            gpu.set_skip_empty(skip_empty);
            let frame = full_frame(&gpu, &mut buffers, &camera);
            let (p999, most, mean) = differences(&expected, &frame);
            assert!(
                p999 <= usual && most <= rare && mean <= 1e-3,
                "{name} skip {skip_empty}: {p999} {most} {mean}"
            );
        }
    }
}

/// Opacity by gradient, of one volume and of two.
#[test]
#[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
fn opacities_by_gradient_are_those_of_the_specification() {
    let curve = || GradientOpacity::new(vec![[0.01, 0.1], [0.05, 1.0]]).unwrap();
    for (name, scene) in layered::scenes().into_iter().filter(|(name, _)| !name.contains("coloured")) {
        for layers in [0, 1] {
            let mut scene = scene.clone();
            scene.layers.truncate(layers);
            scene.transfer_function = scene.transfer_function.clone().with_gradient(Some(curve()));
            for layer in &mut scene.layers {
                layer.transfer_function = layer.transfer_function.clone().with_gradient(Some(curve()));
            }
            for shadows in [ShadowMode::On, ShadowMode::Cached] {
                scene.shading.shadows = shadows;
                agrees(&format!("{name} with {layers} layers by gradient {shadows:?}"), &scene);
            }
        }
    }
}

/// A further volume that is transparent everywhere changes nothing.
#[test]
#[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
fn a_transparent_volume_changes_nothing() {
    let size = FrameSize::new(48, 32).unwrap();
    let mut scene = small_scene();
    scene.integration = Integration::Plain;
    let alone = Renderer::new(&GPU, &scene).unwrap();
    let alone = full_frame(&alone, &mut alone.frame_buffers(size).unwrap(), &cameras()[0]);
    scene.layers.push(Layer {
        volume: scene.volume.clone(),
        transfer_function: TransferFunction::grey_ramp(0.0),
        colours: None,
        interpolation: Interpolation::Linear,
    });
    let both = Renderer::new(&GPU, &scene).unwrap();
    let both = full_frame(&both, &mut both.frame_buffers(size).unwrap(), &cameras()[0]);
    // Colours are packed again.
    assert!(differences(&alone, &both).1 <= 2.0 / 255.0);
}

/// A device that has a scene takes over other transfer functions and interpolations of all volumes.
#[test]
#[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
fn a_changed_scene_is_as_a_new_one() {
    let size = FrameSize::new(48, 32).unwrap();
    let camera = cameras()[0];
    let (_, first) = layered::scenes().swap_remove(1);
    let mut changed = Renderer::new(&GPU, &first).unwrap();
    let mut buffers = changed.frame_buffers(size).unwrap();
    let mut scene = first.clone();
    for shadows in [ShadowMode::On, ShadowMode::Cached] {
        scene.shading.shadows = shadows;
        for layer in 0..2 {
            let function = first.transfer_function.clone();
            let (other, own) = scene.layers.split_at_mut(1);
            std::mem::swap(&mut other[0].interpolation, &mut own[0].interpolation);
            scene.layers[layer].transfer_function = function.over([0.1, 0.9]);
            changed.set_scene(&scene).unwrap();
            let found = full_frame(&changed, &mut buffers, &camera);
            let anew = Renderer::new(&GPU, &scene).unwrap();
            let right = full_frame(&anew, &mut anew.frame_buffers(size).unwrap(), &camera);
            assert_eq!(found.pixels(), right.pixels(), "{shadows:?} {layer}");
            let before = Renderer::new(&GPU, &first).unwrap();
            let before = full_frame(&before, &mut before.frame_buffers(size).unwrap(), &camera);
            assert_ne!(found.pixels(), before.pixels());
        }
    }
}
