//! Parts of volumes, cut at their exact place.

mod scenes;

use fovol_core::{
    Camera, ClipBox, ControlPoint, Frame, FrameSize, Grid, Integration, Light, Pixel, SampleList, Scene,
    ShadowMode, SurfaceShading, TransferFunction, Volume,
};
use fovol_render::cpu::{RenderOptions, Renderer, Simd, available_simd};
use glam::DVec3;
use scenes::{cameras, differences, transfer, volumes};
use std::sync::Arc;

const SIZE: FrameSize = FrameSize { width: 64, height: 48 };

fn cube(side: usize, value: impl Fn([usize; 3]) -> u8) -> Volume {
    let grid = Grid::new([side; 3], [1.0; 3]).unwrap();
    let voxels = (0..grid.voxels()).map(|i| value([i % side, i / side % side, i / (side * side)]));
    Volume::from_values(grid, voxels.collect()).unwrap()
}

/// White of the opacity `a`, whatever the value.
fn haze(a: f64) -> TransferFunction {
    TransferFunction::new(vec![ControlPoint::new(0.0, [1.0; 3], a)]).unwrap()
}

fn clipped(scene: &Scene, low: DVec3, high: DVec3) -> Scene {
    Scene { clip: Some(ClipBox::new(low, high, scene.volume.grid()).unwrap()), ..scene.clone() }
}

fn all_pixels() -> SampleList {
    let pixels = (0..48).flat_map(|y| (0..64).map(move |x| Pixel { x, y }));
    SampleList::new(SIZE, pixels.collect())
}

/// Some pixels all over the frame.
fn some_pixels() -> SampleList {
    let all = all_pixels();
    let pixels = all.pixels().iter().copied().filter(|p| (p.x + 64 * p.y).is_multiple_of(11));
    SampleList::new(SIZE, pixels.collect())
}

#[test]
fn slabs_of_any_thickness_have_the_opacity_of_their_thickness() {
    let a = 0.4f64;
    let mut scene = Scene::new(Arc::new(cube(64, |_| 90)), haze(a));
    let camera = Camera::new(DVec3::new(0.3, 0.2, 1.9), DVec3::ZERO, 20.0).unwrap();
    let rays = camera.rays(SIZE);
    for (from, thickness) in [(32.0, 0.32), (20.7, 0.05), (10.2, 3.9), (31.5, 1.0)] {
        for (integration, step) in [(Integration::Fine, 0.5), (Integration::Plain, 0.01)] {
            (scene.integration, scene.step) = (integration, step);
            let scene = clipped(&scene, DVec3::new(0.0, 0.0, from), DVec3::new(64.0, 64.0, from + thickness));
            for simd in available_simd() {
                let options = RenderOptions { simd, skip_empty: true };
                let renderer = Renderer::new(&scene, options).unwrap();
                let list = some_pixels();
                let (marched, _) = renderer.march_list(&camera, &list);
                let mut seen = 0;
                for (pixel, found) in list.pixels().iter().zip(&marched) {
                    let ray = rays.ray(pixel.x.into(), pixel.y.into());
                    let middle = (from + 0.5 * thickness) / 64.0 - 0.5;
                    let at = ray.origin + ray.direction * ((ray.origin.z - middle) / -ray.direction.z);
                    if at.x.abs() > 0.4 || at.y.abs() > 0.4 {
                        continue;
                    }
                    seen += 1;
                    let right = 1.0 - (1.0 - a).powf(thickness / -ray.direction.z);
                    // Of separate samples one more or less may lie in it.
                    let most = if integration == Integration::Plain { 0.0055 } else { 2e-4 };
                    assert!(
                        (f64::from(found.opacity) - right).abs() < most,
                        "{integration} {simd} {thickness}: {} for {right}",
                        found.opacity
                    );
                    let off = (f64::from(found.depth) - at.distance(ray.origin)).abs() * 64.0;
                    assert!(
                        off < 0.6 * thickness + 0.6,
                        "{integration} {simd} {thickness}: {off} voxels off"
                    );
                }
                assert!(seen > 100, "{seen}");
            }
        }
    }
}

#[test]
fn light_comes_from_the_cut_as_if_nothing_were_beyond() {
    // Light along +x: what is left of it at a depth s below the cut is (1 − a)^s.
    let a = 0.1f64;
    let mut scene = Scene::new(Arc::new(cube(48, |_| 90)), haze(a));
    scene.shading.light = Light::towards(DVec3::X).unwrap();
    scene.shading.ambient = 0.0;
    scene.step = 0.1;
    let camera = Camera::new(DVec3::new(0.02, 0.01, 1.9), DVec3::new(0.02, 0.01, 0.0), 10.0).unwrap();
    let rays = camera.rays(SIZE);
    for integration in [Integration::Fine, Integration::Plain] {
        scene.integration = integration;
        let (low, high) = (DVec3::new(18.3, 10.0, 20.3), DVec3::new(28.6, 40.0, 20.8));
        let renderer = Renderer::new(&clipped(&scene, low, high), RenderOptions::default()).unwrap();
        let (marched, _) = renderer.march_list(&camera, &all_pixels());
        let mut seen = 0;
        for (i, found) in marched.iter().enumerate() {
            let ray = rays.ray(i as u32 % 64, i as u32 / 64);
            let x = |z: f64| {
                let at = ray.origin + ray.direction * ((z / 48.0 - 0.5 - ray.origin.z) / ray.direction.z);
                (at.x + 0.5) * 48.0
            };
            let (enters, leaves) = (x(high.z), x(low.z));
            if enters.min(leaves) < low.x + 0.1 || enters.max(leaves) > high.x - 0.1 {
                continue;
            }
            seen += 1;
            let light = f64::from(found.colour[0] / found.opacity);
            let right = (1.0 - a).powf(high.x - 0.5 * (enters + leaves));
            // Separate samples take shadows in steps of 0.4 voxels.
            let most = if integration == Integration::Plain { 0.025 } else { 0.003 };
            assert!((light - right).abs() < most, "{integration} pixel {i}: {light} for {right}");
        }
        assert!(seen > 700, "{seen}");
    }
}

#[test]
fn cuts_between_voxels_show_what_a_volume_of_that_size_shows() {
    // Values come in pairs, so that a volume of the part alone interpolates no other ones at its faces.
    let value = |[x, y, z]: [usize; 3]| {
        let [x, y, z] = [x, y, z].map(|i| (i / 2) as f64);
        (127.0 + 60.0 * (0.9 * x).sin() * (0.7 * y).cos() + 60.0 * (0.8 * z).sin()) as u8
    };
    let volume = cube(32, value);
    let part = volume.part(&[5..17, 3..27, 9..31]).unwrap();
    let (low, high) = (DVec3::new(5.0, 3.0, 9.0), DVec3::new(17.0, 27.0, 31.0));
    let scale = part.grid().smallest_voxel() / volume.grid().smallest_voxel();
    let centre = volume.grid().grid_to_world((low + high) * 0.5);
    let camera = Camera::new(DVec3::new(1.0, 0.7, 0.9), centre, 35.0).unwrap();
    let moved = |at: DVec3| (at - centre) * scale;
    let camera_of_part = Camera { eye: moved(camera.eye), target: moved(camera.target), ..camera };
    let mut whole = clipped(&Scene::new(Arc::new(volume), transfer()), low, high);
    for shadows in [ShadowMode::On, ShadowMode::Off] {
        for integration in [Integration::Plain, Integration::Fine] {
            whole.shading.shadows = shadows;
            whole.integration = integration;
            let alone = Scene { volume: Arc::new(part.clone()), clip: None, ..whole.clone() };
            let show = |scene: &Scene, camera: &Camera| -> Frame {
                Renderer::new(scene, RenderOptions::default()).unwrap().march_full(camera, SIZE).0
            };
            let frame = show(&whole, &camera);
            let (p999, most, mean) = differences(&frame, &show(&alone, &camera_of_part));
            // A last sample at a face may fall either way.
            assert!(
                p999 < 1.5 / 255.0 && most < 8.0 / 255.0 && mean < 1e-4,
                "{shadows:?} {integration}: {p999} {most} {mean}"
            );
            assert!(frame.pixels().iter().filter(|p| p[0] > 0.1).count() > 300);
        }
    }
}

#[test]
fn every_instruction_set_cuts_as_the_specification() {
    for (name, volume) in volumes() {
        let [x, y, z] = volume.grid().dims().map(|dim| dim as f64);
        let scene = Scene::new(Arc::new(volume), transfer());
        let mut scene =
            clipped(&scene, DVec3::new(0.21 * x, 0.0, 0.333 * z), DVec3::new(0.9 * x, 0.47 * y, 0.87 * z));
        scene.background = [0.1, 0.2, 0.3];
        for (shadows, integration) in [
            (ShadowMode::On, Integration::Plain),
            (ShadowMode::Cached, Integration::Plain),
            (ShadowMode::On, Integration::Fine),
            (ShadowMode::Cached, Integration::Fine),
        ] {
            scene.shading.shadows = shadows;
            scene.shading.surface = SurfaceShading::Gradient;
            scene.integration = integration;
            let scalar = RenderOptions { simd: Simd::Scalar, skip_empty: false };
            let mut renderer = Renderer::new(&scene, scalar).unwrap();
            for camera in cameras() {
                renderer.set_options(scalar);
                let (expected, _) = renderer.march_full(&camera, SIZE);
                for simd in available_simd() {
                    renderer.set_options(RenderOptions { simd, skip_empty: true });
                    let (frame, _) = renderer.march_full(&camera, SIZE);
                    let (p999, most, mean) = differences(&expected, &frame);
                    assert!(
                        p999 <= 1.0 / 255.0 && most <= 8.0 / 255.0 && mean <= 1e-3,
                        "{name} {integration} {shadows:?} {simd}: {p999} {most} {mean}"
                    );
                }
            }
        }
    }
}

#[test]
fn another_part_shows_at_once() {
    let (_, volume) = volumes().remove(0);
    let mut scene = Scene::new(Arc::new(volume), transfer());
    let camera = cameras()[0];
    let mut changed = Renderer::new(&scene, RenderOptions::default()).unwrap();
    let whole = changed.march_full(&camera, SIZE).0;
    for shadows in [ShadowMode::On, ShadowMode::Cached] {
        scene.shading.shadows = shadows;
        scene.clip = None;
        changed.set_scene(&scene).unwrap();
        let cut = clipped(&scene, DVec3::new(10.5, 3.0, 0.0), DVec3::new(40.0, 30.3, 41.0));
        changed.set_scene(&cut).unwrap();
        let fresh = Renderer::new(&cut, RenderOptions::default()).unwrap();
        let shown = changed.march_full(&camera, SIZE).0;
        assert_eq!(shown, fresh.march_full(&camera, SIZE).0);
        assert_ne!(shown, whole);
        let [before, after] = [&Renderer::new(&scene, RenderOptions::default()).unwrap(), &fresh]
            .map(|renderer| renderer.visible_region(&camera, SIZE).unwrap().pixels());
        assert!(after < before, "{after} of {before}");
    }
}
