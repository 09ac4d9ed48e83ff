//! Fine integration against what is right: pictures of small steps, and brightness that follows from equations.

use fovol_core::{
    Camera, ControlPoint, Frame, FrameSize, Grid, Integration, Light, Scene, ShadowMode, TransferFunction,
    Volume,
};
use fovol_render::cpu::{RenderOptions, Renderer};
use glam::DVec3;
use std::sync::Arc;

/// The eye and the light of both cases.
const EYE: DVec3 = DVec3::new(1.2, 0.8, 1.6);
const LIGHT: DVec3 = DVec3::new(1.0, 0.3, 0.2);

fn scene(dims: [usize; 3], value: impl Fn([f64; 3]) -> u8, opacity: [ControlPoint; 4]) -> Scene {
    let mut values = Vec::new();
    for z in 0..dims[2] {
        for y in 0..dims[1] {
            for x in 0..dims[0] {
                values.push(value([x, y, z].map(|i| i as f64 + 0.5)));
            }
        }
    }
    let volume = Volume::from_values(Grid::new(dims, [1.0; 3]).unwrap(), values).unwrap();
    let mut scene = Scene::new(Arc::new(volume), TransferFunction::new(opacity.to_vec()).unwrap());
    scene.shading.light = Light::towards(LIGHT).unwrap();
    scene.integration = Integration::Fine;
    scene
}

fn picture(scene: &Scene, size: FrameSize) -> Frame {
    let camera = Camera::new(EYE, DVec3::ZERO, 35.0).unwrap();
    Renderer::new(scene, RenderOptions::default()).unwrap().march_full(&camera, size).0
}

/// A smooth ball with an edge of opacity at one value.
fn ball() -> Scene {
    let point = ControlPoint::new;
    let value = |p: [f64; 3]| {
        let r = p.map(|x| (x - 32.0) / 32.0).iter().map(|x| x * x).sum::<f64>().sqrt();
        (255.0 * (1.0 - r)).clamp(0.0, 255.0) as u8
    };
    let (hidden, shown) = ([0.0, 0.0, 1.0], [1.0, 0.8, 0.0]);
    let points =
        [point(0.0, hidden, 0.0), point(0.5, hidden, 0.0), point(0.5, shown, 0.95), point(1.0, shown, 0.95)];
    scene([64; 3], value, points)
}

/// The mean difference over the pixels that show anything, in steps of 1/255.
fn difference(a: &Frame, b: &Frame) -> f64 {
    let pairs = a.pixels().iter().zip(b.pixels()).filter(|(a, b)| a[0] > 0.02 || b[0] > 0.02);
    let each: Vec<f64> =
        pairs.flat_map(|(a, b)| (0..3).map(move |c| f64::from((a[c] - b[c]).abs()))).collect();
    255.0 * each.iter().sum::<f64>() / each.len() as f64
}

#[test]
fn half_a_voxel_shows_what_a_twentieth_shows() {
    let size = FrameSize::new(160, 120).unwrap();
    for (shadows, most) in [(ShadowMode::On, 2.0), (ShadowMode::Cached, 2.0), (ShadowMode::Off, 0.2)] {
        let mut scene = ball();
        scene.shading.shadows = shadows;
        let coarse = picture(&scene, size);
        scene.shading.shadows = if shadows == ShadowMode::Cached { ShadowMode::On } else { shadows };
        scene.step = 0.05;
        let fine = picture(&scene, size);
        let apart = difference(&coarse, &fine);
        assert!(apart <= most, "{shadows:?}: {apart}");
        // Separate samples show rings instead.
        scene.integration = Integration::Plain;
        scene.step = 0.5;
        let plain = difference(&picture(&scene, size), &fine);
        assert!(shadows == ShadowMode::Off || plain > 20.0, "{plain}");
    }
}

#[test]
fn the_face_of_a_solid_has_its_analytic_brightness() {
    let point = ControlPoint::new;
    let white = [1.0; 3];
    let points =
        [point(0.0, white, 0.0), point(0.45, white, 0.0), point(0.55, white, 0.9), point(1.0, white, 0.9)];
    // The box is the solid: its face towards +x is what a cut through a larger one leaves.
    let mut scene = scene([32, 64, 64], |_| 255, points);
    let size = FrameSize::new(120, 90).unwrap();
    let camera = Camera::new(EYE, DVec3::ZERO, 35.0).unwrap();
    let half = scene.volume.grid().world_extent() * 0.5;
    let rays = camera.rays(size);
    for shadows in [ShadowMode::On, ShadowMode::Cached] {
        for step in [0.5, 0.3] {
            scene.shading.shadows = shadows;
            scene.step = step;
            let frame = picture(&scene, size);
            let mut seen = 0;
            for (i, pixel) in frame.pixels().iter().enumerate() {
                let ray = rays.ray(i as u32 % 120, i as u32 / 120);
                let at = ray.origin + ray.direction * ((half.x - ray.origin.x) / ray.direction.x);
                if at.y.abs() > 0.8 * half.y || at.z.abs() > 0.8 * half.z {
                    continue;
                }
                // Emission e^(−τs) and light e^(−τsμ) in the depth s: ∫ = 1/(1 + μ).
                let mu = -ray.direction.x / LIGHT.normalize().x;
                let right = 0.3 + 0.7 / (1.0 + mu);
                seen += 1;
                assert!(
                    (f64::from(pixel[0]) - right).abs() < 0.01,
                    "{shadows:?} {step} pixel {i}: {} for {right}",
                    pixel[0]
                );
            }
            assert!(seen > 300, "{seen}");
        }
    }
}

#[test]
fn volumes_of_extreme_aspect_end_in_time() {
    let values: Vec<u8> = (0..17 * 2 * 17).map(|i| (i * 7 % 256) as u8).collect();
    let volume = Volume::from_values(Grid::new([17, 2, 17], [1.0, 1e-7, 1.0]).unwrap(), values).unwrap();
    let faint = |v| ControlPoint::new(v, [1.0; 3], 1e-10);
    let mut scene =
        Scene::new(Arc::new(volume), TransferFunction::new(vec![faint(0.0), faint(1.0)]).unwrap());
    let size = FrameSize::new(32, 24).unwrap();
    let begun = std::time::Instant::now();
    for integration in [Integration::Plain, Integration::Fine] {
        for shadows in [ShadowMode::On, ShadowMode::Off, ShadowMode::Cached] {
            scene.integration = integration;
            scene.shading.shadows = shadows;
            let renderer = Renderer::new(&scene, RenderOptions::default()).unwrap();
            renderer.march_full(&Camera::on_sphere(30.0, 0.0, 1.9, 35.0), size);
        }
    }
    assert!(begun.elapsed().as_secs() < 60, "{:?}", begun.elapsed());
}
