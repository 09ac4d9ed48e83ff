//! Shadow rays from a few places of each ray, chosen at random.

mod scenes;

use fovol_core::{Camera, Frame, FrameSize, Integration, Scene, ShadowMode, SurfaceShading};
use fovol_render::cpu::{FewShadowRays, RenderOptions, Renderer, Simd, available_simd};
use fovol_render::noise::{Noise, NoiseKind};
use scenes::{cameras, differences, transfer, volumes};
use std::sync::Arc;

const SIZE: FrameSize = FrameSize { width: 61, height: 47 };

/// Every scene with both integrations and surfaces, and its name.
fn all_scenes() -> Vec<(String, Scene)> {
    let mut all = Vec::new();
    for (name, volume) in volumes() {
        let mut scene = Scene::new(Arc::new(volume), transfer());
        scene.background = [0.1, 0.2, 0.3];
        for integration in [Integration::Plain, Integration::Fine] {
            for surface in [SurfaceShading::Flat, SurfaceShading::Gradient] {
                scene.integration = integration;
                scene.shading.surface = surface;
                all.push((format!("{name} {integration} {surface:?}"), scene.clone()));
            }
        }
    }
    all
}

/// Full frame with `per_pixel` shadow rays a pixel and the noise of frame `t`.
fn frame(renderer: &Renderer, camera: &Camera, per_pixel: u32, t: u32) -> Frame {
    let noise = Noise::new(NoiseKind::Stbn, 0);
    let few = FewShadowRays { per_pixel, noise: noise.frame(t) };
    renderer.march_full_with(camera, SIZE, Some(&few)).0
}

#[test]
fn every_instruction_set_chooses_as_the_specification() {
    for (name, scene) in all_scenes() {
        let scalar = RenderOptions { simd: Simd::Scalar, skip_empty: false };
        let mut renderer = Renderer::new(&scene, scalar).unwrap();
        for camera in cameras() {
            for per_pixel in [1, 3, 40] {
                renderer.set_options(scalar);
                let expected = frame(&renderer, &camera, per_pixel, 5);
                for simd in available_simd() {
                    renderer.set_options(RenderOptions { simd, skip_empty: true });
                    let (_, _, mean) = differences(&expected, &frame(&renderer, &camera, per_pixel, 5));
                    // Where two places are equally near, rounding chooses.
                    assert!(mean <= 2e-3, "{name} {simd} {per_pixel}: {mean}");
                }
            }
        }
    }
}

#[test]
fn the_mean_over_the_noise_is_the_exact_picture() {
    for (name, scene) in all_scenes() {
        let renderer = Renderer::new(&scene, RenderOptions::default()).unwrap();
        let [camera, ..] = cameras();
        let (exact, _) = renderer.march_full(&camera, SIZE);
        let mut mean = Frame::new(SIZE);
        for t in 0..64 {
            let one = frame(&renderer, &camera, 1, t);
            for (sum, pixel) in mean.pixels_mut().iter_mut().zip(one.pixels()) {
                (0..4).for_each(|c| sum[c] += pixel[c] / 64.0);
            }
        }
        let (p999, _, off) = differences(&exact, &mean);
        assert!(p999 < 0.06 && off < 4e-3, "{name}: {p999} {off}");
    }
}

#[test]
fn more_shadow_rays_are_nearer_to_the_exact_picture() {
    for (name, scene) in all_scenes() {
        let renderer = Renderer::new(&scene, RenderOptions::default()).unwrap();
        for camera in cameras() {
            let (exact, _) = renderer.march_full(&camera, SIZE);
            let off = [1, 4, 16, 64].map(|per_pixel| {
                let (_, _, mean) = differences(&exact, &frame(&renderer, &camera, per_pixel, 2));
                mean
            });
            assert!(off.windows(2).all(|two| two[1] < 0.6 * two[0]), "{name}: {off:?}");
            assert!(off[3] < 2e-3, "{name}: {off:?}");
        }
    }
}

#[test]
fn few_shadow_rays_take_few_samples_and_other_shadows_none() {
    let (_, volume) = volumes().remove(0);
    let mut scene = Scene::new(Arc::new(volume), transfer());
    scene.integration = Integration::Plain;
    let [camera, ..] = cameras();
    let noise = Noise::new(NoiseKind::Stbn, 0);
    let few = FewShadowRays { per_pixel: 2, noise: noise.frame(0) };
    let mut renderer = Renderer::new(&scene, RenderOptions::default()).unwrap();
    let (_, exact) = renderer.march_full(&camera, SIZE);
    let (_, counted) = renderer.march_full_with(&camera, SIZE, Some(&few));
    assert_eq!(counted.primary, exact.primary);
    assert!(counted.shadow > 0 && 2 * counted.shadow < exact.shadow, "{} {}", counted.shadow, exact.shadow);
    for shadows in [ShadowMode::Off, ShadowMode::Cached] {
        scene.shading.shadows = shadows;
        renderer.set_scene(&scene).unwrap();
        let (expected, _) = renderer.march_full(&camera, SIZE);
        assert_eq!(renderer.march_full_with(&camera, SIZE, Some(&few)).0.pixels(), expected.pixels());
    }
}
