//! Values that are not numbers.

mod gaps;
mod scenes;

use fovol_core::{
    Camera, ControlPoint, FrameSize, Grid, Integration, Light, Pixel, SampleList, Scene, ShadowMode,
    SurfaceShading, TransferFunction, Volume,
};
use fovol_render::cpu::{RenderOptions, Renderer, Simd, available_simd};
use fovol_render::scene::Bricks;
use glam::DVec3;
use scenes::{cameras, differences, transfer};
use std::sync::Arc;

const SIZE: FrameSize = FrameSize { width: 64, height: 48 };
const RED: [f64; 4] = [1.0, 0.0, 0.0, 0.3];

/// 32³ voxels of 5 within [0, 10] but for NaN where `is_nan` says so.
fn cube(is_nan: impl Fn([usize; 3]) -> bool) -> Volume {
    let grid = Grid::new([32; 3], [1.0; 3]).unwrap();
    let value = |i: usize| if is_nan([i % 32, i / 32 % 32, i / 1024]) { f32::NAN } else { 5.0 };
    let volume = Volume::from_values(grid, (0..grid.voxels()).map(value).collect()).unwrap();
    volume.with_range([0.0, 10.0]).unwrap()
}

/// Green of the opacity 0.1.
fn green() -> TransferFunction {
    TransferFunction::new(vec![ControlPoint::new(0.0, [0.0, 1.0, 0.0], 0.1)]).unwrap()
}

fn options() -> Vec<RenderOptions> {
    let of = |simd| [false, true].map(|skip_empty| RenderOptions { simd, skip_empty });
    available_simd().into_iter().flat_map(of).collect()
}

fn all_pixels() -> SampleList {
    let pixels = (0..48).flat_map(|y| (0..64).map(move |x| Pixel { x, y }));
    SampleList::new(SIZE, pixels.collect())
}

#[test]
fn one_nan_spoils_the_samples_of_the_cells_around_it() {
    let bricks = Bricks::of_volume(&cube(|at| at == [10, 11, 12])).unwrap();
    assert!(bricks.has_gaps() && bricks.has_gaps_in([8, 8, 8], 8) && !bricks.has_gaps_in([16, 8, 8], 8));
    for (p, is_nan) in [
        ([9.01, 11.0, 12.0], true),
        ([10.0, 10.5, 12.99], true),
        ([9.0, 11.0, 12.0], true),
        ([8.99, 11.0, 12.0], false),
        ([11.0, 11.0, 12.0], false),
        ([10.0, 11.0, 13.0], false),
    ] {
        assert_eq!(bricks.sample(p).is_nan(), is_nan, "{p:?}");
    }
    assert_eq!(bricks.value_range([8, 8, 8], 8), [0.5; 2]);
    assert!(!Bricks::of_volume(&cube(|_| false)).unwrap().has_gaps());
}

#[test]
fn infinite_values_are_the_lowest() {
    let grid = Grid::new([2, 2, 1], [1.0; 3]).unwrap();
    let values = vec![f32::INFINITY, f32::NEG_INFINITY, f32::NAN, 10.0];
    let bricks =
        Bricks::of_volume(&Volume::from_values(grid, values).unwrap().with_range([0.0, 10.0]).unwrap())
            .unwrap();
    assert_eq!((bricks.voxel([0, 0, 0]), bricks.voxel([1, 0, 0])), (0.0, 0.0));
    assert!(bricks.voxel([0, 1, 0]).is_nan() && bricks.voxel([1, 1, 0]) == 1.0);
}

/// A slab of NaN voxels, z = 12…19, spoils all between their neighbours' centres: 9 voxels.
const SPOILT: f64 = 9.0;

#[test]
fn a_slab_of_nan_has_the_opacity_that_it_is_given() {
    let volume = Arc::new(cube(|[_, _, z]| (12..20).contains(&z)));
    let camera = Camera::new(DVec3::new(0.2, 0.1, 1.9), DVec3::ZERO, 18.0).unwrap();
    let rays = camera.rays(SIZE);
    for nan in [[0.0; 4], RED] {
        let mut scene = Scene::new(Arc::clone(&volume), green().with_nan(nan).unwrap());
        scene.shading.shadows = ShadowMode::Off;
        for (integration, step) in [(Integration::Fine, 0.1), (Integration::Plain, 0.02)] {
            (scene.integration, scene.step) = (integration, step);
            let mut renderer = Renderer::new(&scene, options()[0]).unwrap();
            for option in options() {
                renderer.set_options(option);
                let (marched, _) = renderer.march_list(&camera, &all_pixels());
                let mut seen = 0;
                for (i, found) in marched.iter().enumerate() {
                    let ray = rays.ray(i as u32 % 64, i as u32 / 64);
                    let at = ray.origin + ray.direction * (ray.origin.z / -ray.direction.z);
                    if at.x.abs() > 0.3 || at.y.abs() > 0.25 {
                        continue;
                    }
                    seen += 1;
                    let along = 1.0 / -ray.direction.z;
                    let passes = |a: f64, voxels: f64| (1.0 - a).powf(voxels * along);
                    // 11.5 voxels of green before and after what is spoilt.
                    let (before, spoilt) = (passes(0.1, 11.5), passes(nan[3], SPOILT));
                    let right = [
                        before * (1.0 - spoilt),
                        (1.0 - before) * (1.0 + before * spoilt),
                        1.0 - before * before * spoilt,
                    ];
                    let found = [found.colour[0], found.colour[1], found.opacity].map(f64::from);
                    for c in 0..3 {
                        // Up to two steps belong to NaN or not.
                        let most = if integration == Integration::Fine { 0.012 } else { 0.002 };
                        assert!(
                            (found[c] - right[c]).abs() < most,
                            "{integration} {option:?} {nan:?} pixel {i}: {found:?} for {right:?}"
                        );
                    }
                }
                assert!(seen > 500, "{seen}");
            }
        }
    }
}

#[test]
fn nan_casts_the_shadow_of_its_opacity() {
    // Light along +z. What lies below the slab has the light that passes it, and the green above.
    let volume = Arc::new(cube(|[_, _, z]| (12..20).contains(&z)));
    let camera = Camera::new(DVec3::new(0.0, 0.0, -1.9), DVec3::ZERO, 10.0).unwrap();
    for nan in [[0.0; 4], RED] {
        let mut scene = Scene::new(Arc::clone(&volume), green().with_nan(nan).unwrap());
        scene.shading.light = Light::towards(DVec3::Z).unwrap();
        scene.shading.ambient = 0.0;
        scene.step = 0.05;
        for integration in [Integration::Fine, Integration::Plain] {
            scene.integration = integration;
            let mut renderer = Renderer::new(&scene, options()[0]).unwrap();
            for option in options() {
                renderer.set_options(option);
                let middle = SampleList::new(SIZE, vec![Pixel { x: 32, y: 24 }]);
                let found = renderer.march_list(&camera, &middle).0[0];
                // Green is emitted along s voxels of what the eye meets first, 11.5 voxels of it before the slab:
                // ∫ τ e^(−τs) e^(−τ(11.5 − s)) ds = τ·11.5·e^(−11.5τ), times what passes slab and rest.
                let tau = -(1.0f64 - 0.1).ln();
                let (green, spoilt) = ((-11.5 * tau).exp(), (1.0 - nan[3]).powf(SPOILT));
                let before = 11.5 * tau * green * spoilt * green;
                let after = green * spoilt * 11.5 * tau * green;
                let right = before + after;
                let most = if integration == Integration::Plain { 0.006 } else { 0.004 };
                assert!(
                    (f64::from(found.colour[1]) - right).abs() < most,
                    "{integration} {option:?} {nan:?}: {} for {right}",
                    found.colour[1]
                );
            }
        }
    }
}

#[test]
fn every_instruction_set_shows_nan_as_the_specification() {
    let volume = Arc::new(gaps::volume());
    for nan in [[0.0; 4], [0.9, 0.1, 0.2, 0.4]] {
        let mut scene = Scene::new(Arc::clone(&volume), transfer().with_nan(nan).unwrap());
        scene.background = [0.1, 0.2, 0.3];
        for integration in [Integration::Plain, Integration::Fine] {
            for shadows in [ShadowMode::On, ShadowMode::Off, ShadowMode::Cached] {
                scene.integration = integration;
                scene.shading.shadows = shadows;
                scene.shading.surface = SurfaceShading::Gradient;
                let scalar = RenderOptions { simd: Simd::Scalar, skip_empty: false };
                let mut renderer = Renderer::new(&scene, scalar).unwrap();
                for camera in cameras() {
                    renderer.set_options(scalar);
                    let (expected, _) = renderer.march_full(&camera, SIZE);
                    for option in options() {
                        renderer.set_options(option);
                        let (frame, _) = renderer.march_full(&camera, SIZE);
                        let (p999, most, mean) = differences(&expected, &frame);
                        assert!(
                            p999 <= 2.0 / 255.0 && most <= 16.0 / 255.0 && mean <= 1e-3,
                            "{integration} {shadows:?} {nan:?} {option:?}: {p999} {most} {mean}"
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn nothing_but_nan_shows_its_colour_or_nothing() {
    let volume = Arc::new(cube(|_| true));
    let camera = cameras()[0];
    for option in options() {
        for integration in [Integration::Plain, Integration::Fine] {
            let mut scene = Scene::new(Arc::clone(&volume), green());
            scene.integration = integration;
            let empty = Renderer::new(&scene, option).unwrap();
            assert!(empty.march_full(&camera, SIZE).0.pixels().iter().all(|p| p[..3] == [0.0; 3]));
            assert_eq!(empty.macrocells().occupied(), 0.0);
            scene.transfer_function = green().with_nan([0.0, 0.0, 1.0, 1.0]).unwrap();
            scene.shading.shadows = ShadowMode::Off;
            let blue = Renderer::new(&scene, option).unwrap().march_full(&camera, SIZE).0;
            let middle = blue.pixel(32, 24);
            assert!(middle[0] == 0.0 && middle[1] == 0.0 && middle[2] > 0.99, "{integration} {middle:?}");
        }
    }
}
