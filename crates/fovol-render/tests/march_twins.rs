//! The fast marchers against the specification.

mod scenes;

use fovol_core::{
    CameraPath, ControlPoint, Frame, FrameSize, Grid, Integration, Light, Pixel, SampleList, Scene,
    ShadowMode, SurfaceShading, TransferFunction, Volume,
};
use fovol_render::cpu::{RenderOptions, Renderer, Simd, available_simd};
use scenes::{cameras, differences, transfer, volumes};
use std::sync::Arc;

#[test]
fn every_instruction_set_agrees_with_the_specification() {
    for (name, volume) in volumes() {
        let mut scene = Scene::new(Arc::new(volume), transfer());
        scene.background = [0.1, 0.2, 0.3];
        for integration in [Integration::Plain, Integration::Fine] {
            scene.integration = integration;
            agrees_with_the_specification(name, scene.clone());
        }
    }
}

/// Asserts that pictures of `scene` in every shading and from every camera match the specification.
fn agrees_with_the_specification(name: &str, mut scene: Scene) {
    let size = FrameSize::new(93, 61).unwrap();
    let integration = scene.integration;
    {
        for shadows in [ShadowMode::On, ShadowMode::Off, ShadowMode::Cached] {
            for surface in [SurfaceShading::Flat, SurfaceShading::Gradient] {
                scene.shading.shadows = shadows;
                scene.shading.surface = surface;
                let scalar = RenderOptions { simd: Simd::Scalar, skip_empty: false };
                let mut renderer = Renderer::new(&scene, scalar).unwrap();
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
                                "{name} {integration} {shadows:?} {surface:?} {simd} skip {skip_empty}: {p999} {most} {mean}"
                            );
                        }
                    }
                }
            }
        }
    }
}

/// Single voxels in empty space, under a steep transfer function. Steps begin in a visible cell and end in an empty
/// one, wherever blocks of steps end.
#[test]
fn empty_space_takes_no_step_of_fine_integration_with_it() {
    let dims = [41, 37, 43];
    let grid = Grid::new(dims, [1.0; 3]).unwrap();
    let mut state = 12345u32;
    let values = (0..grid.voxels()).map(|_| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        if state >> 16 < 60 { 255u8 } else { 0 }
    });
    let volume = Volume::from_values(grid, values.collect()).unwrap();
    let point = |at, alpha| ControlPoint::new(at, [1.0; 3], alpha);
    let steep = vec![point(0.0, 0.0), point(0.01, 0.0), point(0.02, 0.9), point(1.0, 0.9)];
    let mut scene = Scene::new(Arc::new(volume), TransferFunction::new(steep).unwrap());
    scene.integration = Integration::Fine;
    let size = FrameSize::new(93, 61).unwrap();
    for (shadows, step) in [(ShadowMode::On, 0.5), (ShadowMode::Cached, 0.31), (ShadowMode::Off, 0.5)] {
        scene.shading.shadows = shadows;
        scene.step = step;
        for simd in available_simd().into_iter().filter(|simd| *simd != Simd::Scalar) {
            let [all, some] = [false, true].map(|skip_empty| {
                let renderer = Renderer::new(&scene, RenderOptions { simd, skip_empty }).unwrap();
                cameras().map(|camera| renderer.march_full(&camera, size).0)
            });
            for (all, some) in all.iter().zip(&some) {
                let (_, most, _) = differences(all, some);
                assert!(most <= 1e-4, "{shadows:?} {simd}: {most}");
            }
        }
    }
}

#[test]
fn depths_agree_with_the_specification() {
    let size = FrameSize::new(93, 61).unwrap();
    let pixels: Vec<Pixel> = (0..61).flat_map(|y| (0..93).map(move |x| Pixel { x, y })).collect();
    let list = SampleList::new(size, pixels);
    for (name, volume) in volumes() {
        let scene = Scene::new(Arc::new(volume), transfer());
        let options = RenderOptions { simd: Simd::Scalar, skip_empty: false };
        let mut renderer = Renderer::new(&scene, options).unwrap();
        for camera in cameras() {
            renderer.set_options(options);
            let (expected, _) = renderer.march_list(&camera, &list);
            // One step: where opacity passes one half turns on its last bits.
            let step = 0.5 * scene.volume.grid().smallest_voxel() as f32;
            let met = expected.iter().filter(|sample| sample.depth.is_finite()).count();
            assert!(met > 500, "{name}: {met}");
            for simd in available_simd() {
                renderer.set_options(RenderOptions { simd, skip_empty: true });
                let (found, _) = renderer.march_list(&camera, &list);
                let far = expected.iter().zip(&found).filter(|(expected, found)| {
                    let agrees = (expected.depth - found.depth).abs() <= 1.01 * step + 1e-4 * expected.depth;
                    !agrees && expected.depth != found.depth && expected.opacity > 0.01
                });
                // At the edges of thin things one half may be passed at the front or at the back.
                let far = far.count();
                assert!(far * 500 <= met, "{name} {simd}: {far} of {met}");
            }
        }
    }
}

/// Rays with shadow rays return the colour of rays without. With cached shadows they return their own.
#[test]
fn colours_without_shadows_are_those_of_a_march_without_shadows() {
    let size = FrameSize::new(93, 61).unwrap();
    let pixels: Vec<Pixel> = (0..61).flat_map(|y| (0..93).map(move |x| Pixel { x, y })).collect();
    let list = SampleList::new(size, pixels);
    for (name, volume) in volumes() {
        let mut scene = Scene::new(Arc::new(volume), transfer());
        scene.background = [0.1, 0.2, 0.3];
        for integration in [Integration::Plain, Integration::Fine] {
            for surface in [SurfaceShading::Flat, SurfaceShading::Gradient] {
                (scene.integration, scene.shading.surface) = (integration, surface);
                let mut renderer = Renderer::new(&scene, RenderOptions::default()).unwrap();
                for simd in available_simd() {
                    renderer.set_options(RenderOptions { simd, skip_empty: true });
                    let camera = cameras()[0];
                    let lit = renderer.march_list(&camera, &list).0;
                    let unlit = renderer.march_list_without_shadows(&camera, &list).0;
                    assert_eq!(renderer.march_list(&camera, &list).0, lit);
                    let (mut darker, mut most) = (0, 0.0f32);
                    for (lit, unlit) in lit.iter().zip(&unlit) {
                        for c in 0..3 {
                            let background = (1.0 - lit.opacity) * scene.background[c] as f32;
                            most = most.max((lit.unshadowed[c] - unlit.unshadowed[c]).abs());
                            most = most.max((unlit.colour[c] - background - unlit.unshadowed[c]).abs());
                            let shadowed = lit.colour[c] - background;
                            assert!(shadowed <= lit.unshadowed[c] + 1e-5, "{lit:?}");
                            darker += usize::from(shadowed < 0.9 * lit.unshadowed[c] - 0.01);
                        }
                    }
                    assert!(most < 1e-4, "{name} {integration} {surface:?} {simd}: {most}");
                    assert!(darker > 500, "{name} {integration} {surface:?} {simd}: {darker}");
                }
            }
        }
        scene.shading.shadows = ShadowMode::Cached;
        let renderer = Renderer::new(&scene, RenderOptions::default()).unwrap();
        for found in renderer.march_list(&cameras()[0], &list).0 {
            for c in 0..3 {
                let over = found.unshadowed[c] + (1.0 - found.opacity) * scene.background[c] as f32;
                assert!((over - found.colour[c]).abs() < 1e-5, "{found:?}");
            }
        }
    }
}

#[test]
fn one_thread_and_many_give_the_same_bytes() {
    let (_, volume) = volumes().remove(0);
    let renderer =
        Renderer::new(&Scene::new(Arc::new(volume), transfer()), RenderOptions::default()).unwrap();
    let size = FrameSize::new(160, 90).unwrap();
    let frames: Vec<Frame> = [1, 2, 5]
        .into_iter()
        .map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| renderer.march_full(&CameraPath::Orbit.camera(3), size).0)
        })
        .collect();
    assert_eq!(frames[0], frames[1]);
    assert_eq!(frames[0], frames[2]);
}

#[test]
fn a_changed_scene_shows_at_once() {
    let (_, volume) = volumes().remove(0);
    let mut scene = Scene::new(Arc::new(volume), transfer());
    scene.shading.shadows = ShadowMode::Cached;
    let size = FrameSize::new(64, 64).unwrap();
    let camera = CameraPath::Orbit.camera(0);
    let mut changed = Renderer::new(&scene, RenderOptions::default()).unwrap();
    let changes: [fn(&mut Scene); 6] = [
        |scene| scene.transfer_function = TransferFunction::grey_ramp(0.3),
        |scene| scene.shading.light = Light::towards([-1.0, 0.2, 0.0].into()).unwrap(),
        |scene| scene.shading.ambient = 0.5,
        |scene| scene.background = [0.2, 0.3, 0.4],
        |scene| scene.step = 0.8,
        |scene| scene.shading.shadows = ShadowMode::On,
    ];
    let mut last = changed.march_full(&camera, size).0;
    for change in changes {
        change(&mut scene);
        changed.set_scene(&scene).unwrap();
        let fresh = Renderer::new(&scene, RenderOptions::default()).unwrap();
        let shown = changed.march_full(&camera, size).0;
        assert_eq!(shown, fresh.march_full(&camera, size).0);
        assert_ne!(shown, last);
        last = shown;
    }
    scene.step = 0.0;
    assert!(changed.set_scene(&scene).is_err());
    assert_eq!(changed.march_full(&camera, size).0, last);
}

#[test]
fn one_voxel_and_thin_volumes_render() {
    for dims in [[1, 1, 1], [1, 30, 2], [17, 1, 1], [2, 2, 2]] {
        let grid = Grid::new(dims, [1.0; 3]).unwrap();
        let volume = Volume::from_values(grid, vec![200u8; grid.voxels()]).unwrap();
        let scene = Scene::new(Arc::new(volume), TransferFunction::grey_ramp(0.9));
        for simd in available_simd() {
            let renderer = Renderer::new(&scene, RenderOptions { simd, skip_empty: true }).unwrap();
            let (frame, count) =
                renderer.march_full(&CameraPath::Orbit.camera(0), FrameSize::new(41, 31).unwrap());
            assert!(count.primary > 0 && frame.pixel(20, 15)[0] > 0.1, "{dims:?} {simd}");
        }
    }
}
