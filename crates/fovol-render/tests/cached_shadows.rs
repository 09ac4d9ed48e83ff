//! Cached shadows against shadow rays.

use fovol_core::{
    Camera, ClipBox, Frame, FrameSize, Integration, Light, Pixel, SampleList, Scene, ShadowMode,
    TransferFunction, Volume,
};
use fovol_render::cpu::{RenderOptions, Renderer};
use glam::DVec3;
use std::sync::Arc;

/// Balls in a smooth fog.
fn volume() -> Volume {
    let grid = fovol_core::Grid::new([48, 40, 44], [1.0, 1.2, 1.1]).unwrap();
    let [nx, ny, _] = grid.dims();
    let value = |i: usize| {
        let p =
            DVec3::new((i % nx) as f64 / 48.0, (i / nx % ny) as f64 / 40.0, (i / (nx * ny)) as f64 / 44.0);
        let ball =
            |centre: [f64; 3], radius: f64| (1.0 - (p - DVec3::from(centre)).length() / radius).max(0.0);
        let fog = 0.15 + 0.1 * (9.0 * p.x).sin() * (7.0 * p.y).cos();
        (fog + ball([0.3, 0.4, 0.5], 0.3) + ball([0.7, 0.6, 0.4], 0.25)).min(1.0) as f32
    };
    Volume::from_values(grid, (0..grid.voxels()).map(value).collect()).unwrap()
}

/// Mean difference of all channels, that of all but one in a thousand, and the greatest.
fn differences(a: &Frame, b: &Frame) -> [f32; 3] {
    let pairs = a.pixels().iter().flatten().zip(b.pixels().iter().flatten());
    let mut all: Vec<f32> = pairs.map(|(a, b)| (a - b).abs()).collect();
    all.sort_by(f32::total_cmp);
    [all.iter().sum::<f32>() / all.len() as f32, all[all.len() - 1 - all.len() / 1000], all[all.len() - 1]]
}

#[test]
fn cached_shadows_are_close_to_shadow_rays() {
    let volume = Arc::new(volume());
    let size = FrameSize::new(160, 120).unwrap();
    let clip = ClipBox::new(DVec3::new(5.3, 0.0, 8.0), DVec3::new(48.0, 33.7, 40.0), volume.grid()).unwrap();
    let camera = Camera::new(DVec3::new(1.0, 0.8, 1.2), DVec3::ZERO, 40.0).unwrap();
    let lights = [[1.0, 0.3, 0.2], [0.1, -1.0, 0.3], [-0.3, 0.2, 1.0], [1.0, 1.0, 1.0], [0.0, 0.0, -1.0]];
    for opacity in [0.1, 0.9] {
        for light in lights {
            for clip in [None, Some(clip)] {
                for integration in [Integration::Plain, Integration::Fine] {
                    let mut scene = Scene::new(Arc::clone(&volume), TransferFunction::grey_ramp(opacity));
                    scene.shading.light = Light::towards(light.into()).unwrap();
                    (scene.clip, scene.integration) = (clip, integration);
                    let picture = |shadows| {
                        let mut scene = scene.clone();
                        scene.shading.shadows = shadows;
                        Renderer::new(&scene, RenderOptions::default()).unwrap().march_full(&camera, size).0
                    };
                    let [exact, cached] = [ShadowMode::On, ShadowMode::Cached].map(picture);
                    let [mean, p999, most] = differences(&exact, &cached);
                    let name = format!("{opacity} {light:?} {integration} {}", clip.is_some());
                    assert!(
                        mean < 0.6 / 255.0 && p999 < 4.0 / 255.0 && most < 10.0 / 255.0,
                        "{name}: {mean} {p999} {most}"
                    );
                }
            }
        }
    }
}

#[test]
fn changes_of_the_scene_show_at_once() {
    let volume = Arc::new(volume());
    let size = FrameSize::new(80, 60).unwrap();
    let camera = Camera::new(DVec3::new(1.0, 0.8, 1.2), DVec3::ZERO, 40.0).unwrap();
    let scene = |shadows, light: [f64; 3], opacity, step| {
        let mut scene = Scene::new(Arc::clone(&volume), TransferFunction::grey_ramp(opacity));
        scene.shading.shadows = shadows;
        scene.shading.light = Light::towards(light.into()).unwrap();
        scene.step = step;
        scene
    };
    let (left, right) = ([-1.0, 0.4, 0.2], [1.0, 0.4, 0.2]);
    let clip = ClipBox::new(DVec3::ZERO, DVec3::new(48.0, 20.0, 44.0), volume.grid()).unwrap();
    let scenes = [
        scene(ShadowMode::Cached, left, 0.5, 0.5),
        scene(ShadowMode::On, left, 0.5, 0.5),
        scene(ShadowMode::Cached, left, 0.5, 0.5),
        scene(ShadowMode::On, right, 0.5, 0.5),
        scene(ShadowMode::Cached, right, 0.5, 0.5),
        scene(ShadowMode::Cached, right, 0.9, 0.5),
        scene(ShadowMode::Off, right, 0.9, 1.0),
        scene(ShadowMode::Cached, right, 0.9, 1.0),
        scene(ShadowMode::Cached, right, 0.9, 0.5),
        scene(ShadowMode::Cached, right, 0.9, 2.0),
        Scene { integration: Integration::Fine, ..scene(ShadowMode::Cached, right, 0.9, 1.0) },
        scene(ShadowMode::Cached, right, 0.9, 0.5),
        Scene { clip: Some(clip), ..scene(ShadowMode::Cached, right, 0.9, 1.0) },
    ];
    let mut renderer = Renderer::new(&scenes[0], RenderOptions::default()).unwrap();
    for (i, scene) in scenes.iter().enumerate() {
        renderer.set_scene(scene).unwrap();
        let anew = Renderer::new(scene, RenderOptions::default()).unwrap();
        assert!(renderer.march_full(&camera, size).0 == anew.march_full(&camera, size).0, "{i}");
        assert_eq!(renderer.shadow_grid_time().is_zero(), scene.shading.shadows != ShadowMode::Cached);
    }
}

#[test]
fn lists_with_another_step_and_other_shadows_leave_the_scene_as_it_was() {
    let volume = Arc::new(volume());
    let size = FrameSize::new(80, 60).unwrap();
    let list = SampleList::new(size, (0..40).map(|x| Pixel { x: 2 * x, y: x }).collect());
    let camera = Camera::new(DVec3::new(1.0, 0.8, 1.2), DVec3::ZERO, 40.0).unwrap();
    let scene = |shadows, step| {
        let mut scene = Scene::new(Arc::clone(&volume), TransferFunction::grey_ramp(0.5));
        scene.shading.shadows = shadows;
        Scene { step, integration: Integration::Fine, ..scene }
    };
    let own = scene(ShadowMode::Cached, 0.5);
    let mut renderer = Renderer::new(&own, RenderOptions::default()).unwrap();
    let before = renderer.march_full(&camera, size).0;
    for _ in 0..2 {
        for shadows in [ShadowMode::On, ShadowMode::Off, ShadowMode::Cached] {
            for step in [0.5, 1.0, 2.0, 3.0] {
                let other = Renderer::new(&scene(shadows, step), RenderOptions::default()).unwrap();
                let marched = renderer.march_list_as((shadows, step), &camera, &list).unwrap();
                assert_eq!(marched, other.march_list(&camera, &list), "{shadows:?} {step}");
            }
        }
        assert!(renderer.march_full(&camera, size).0 == before);
    }
}
