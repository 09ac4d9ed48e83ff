//! Several volumes at the same points, and voxels with colours: the fast marchers against the specification.

mod gaps;
mod layered;
mod scenes;

use fovol_core::{
    Camera, FrameSize, Interpolation, Layer, Pixel, RayMode, SampleList, Scene, ShadowMode, SurfaceShading,
};
use fovol_render::cpu::{RenderOptions, Renderer, Simd, available_simd};
use scenes::{cameras, differences, transfer, volumes};
use std::sync::Arc;

#[test]
fn every_instruction_set_agrees_with_the_specification() {
    for (name, mut scene) in layered::scenes() {
        for shadows in [ShadowMode::On, ShadowMode::Off, ShadowMode::Cached] {
            for surface in [SurfaceShading::Flat, SurfaceShading::Gradient] {
                scene.shading.shadows = shadows;
                scene.shading.surface = surface;
                agrees(&format!("{name} {shadows:?} {surface:?}"), &scene);
            }
        }
    }
}

#[test]
fn projections_of_every_instruction_set_agree_with_the_specification() {
    for (name, scene) in layered::projections() {
        agrees(&name, &scene);
    }
}

fn agrees(name: &str, scene: &Scene) {
    let size = FrameSize::new(93, 61).unwrap();
    let scalar = RenderOptions { simd: Simd::Scalar, skip_empty: false };
    let mut renderer = Renderer::new(scene, scalar).unwrap();
    for camera in cameras() {
        renderer.set_options(scalar);
        let (expected, _) = renderer.march_full(&camera, size);
        for simd in available_simd() {
            for skip_empty in [false, true] {
                renderer.set_options(RenderOptions { simd, skip_empty });
                let (frame, _) = renderer.march_full(&camera, size);
                let (p999, most, mean) = differences(&expected, &frame);
                assert!(
                    p999 <= 1.0 / 255.0 && most <= 8.0 / 255.0 && mean <= 1e-3,
                    "{name} {simd} skip {skip_empty}: {p999} {most} {mean}"
                );
            }
        }
    }
}

fn list() -> SampleList {
    let pixels = (0..32).flat_map(|y| (0..48).map(move |x| Pixel { x, y })).collect();
    SampleList::new(FrameSize::new(48, 32).unwrap(), pixels)
}

fn results(scene: &Scene, camera: &Camera) -> Vec<fovol_render::scene::RayResult> {
    Renderer::new(scene, RenderOptions::default()).unwrap().march_list(camera, &list()).0
}

/// A volume and itself with the same transfer function: twice the extinction, the same colours.
#[test]
fn a_volume_twice_is_a_denser_one() {
    let volume = Arc::new(volumes().remove(0).1);
    let mut once = Scene::new(Arc::clone(&volume), transfer());
    let layer =
        Layer { volume, transfer_function: transfer(), colours: None, interpolation: Interpolation::Linear };
    let twice = Scene { layers: vec![layer], ..once.clone() };
    let single = transfer();
    let doubled = single.points().iter().map(|point| {
        let clear = 1.0 - point.opacity;
        fovol_core::ControlPoint::new(point.value, point.colour, 1.0 - clear * clear)
    });
    once.transfer_function = fovol_core::TransferFunction::new(doubled.collect()).unwrap();
    // Between points opacities are interpolated, not extinctions, so that some are somewhat larger.
    for camera in cameras() {
        for (once, twice) in results(&once, &camera).iter().zip(results(&twice, &camera)) {
            assert!((once.opacity - twice.opacity).abs() < 0.05, "{once:?} {twice:?}");
        }
    }
}

#[test]
fn a_changed_transfer_function_of_a_layer_is_as_a_new_one() {
    let mut scene = layered::scenes().remove(0).1;
    let camera = cameras()[0];
    for shadows in [ShadowMode::On, ShadowMode::Cached] {
        scene.shading.shadows = shadows;
        let mut changed = Renderer::new(&scene, RenderOptions::default()).unwrap();
        changed.march_list(&camera, &list());
        let mut other = scene.clone();
        other.layers[0].transfer_function = fovol_core::TransferFunction::grey_ramp(0.4);
        other.layers[0].interpolation = Interpolation::Nearest;
        changed.set_scene(&other).unwrap();
        assert_eq!(changed.march_list(&camera, &list()).0, results(&other, &camera));
        assert_ne!(results(&scene, &camera), results(&other, &camera));
    }
}

#[test]
fn what_cannot_be_shown_together_is_refused() {
    let (_, mut scene) = layered::scenes().remove(0);
    scene.mode = RayMode::Isosurface(0.5);
    assert!(scene.check().unwrap_err().to_string().contains("isosurface"));
    scene.mode = RayMode::Composite;
    scene.layers = vec![scene.layers[0].clone(); 4];
    assert!(scene.check().unwrap_err().to_string().contains("at most 4"));
    scene.layers.truncate(1);
    scene.layers[0].volume = Arc::new(volumes().remove(1).1);
    assert!(scene.check().unwrap_err().to_string().contains("resample"));
}
