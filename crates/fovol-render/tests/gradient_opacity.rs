//! Opacity that depends on the gradient: the fast marchers against the specification.

mod gaps;
mod scenes;

use fovol_core::{
    Camera, ControlPoint, Frame, FrameSize, GradientOpacity, Grid, Integration, Interpolation, Layer,
    RayMode, Scene, ShadowMode, SurfaceShading, TransferFunction, Volume,
};
use fovol_render::cpu::{RenderOptions, Renderer, Simd, available_simd};
use scenes::{cameras, differences, transfer, volumes};
use std::sync::Arc;

fn curve(points: &[[f64; 2]]) -> Option<GradientOpacity> {
    Some(GradientOpacity::new(points.to_vec()).unwrap())
}

/// Scenes of every type of voxel, of one and of several volumes.
fn all() -> Vec<(String, Scene)> {
    let graded = transfer().with_gradient(curve(&[[0.01, 0.0], [0.08, 1.0]]));
    let mut scenes = Vec::new();
    let volumes: Vec<_> = volumes().into_iter().map(|(name, volume)| (name, Arc::new(volume))).collect();
    for (name, volume) in &volumes {
        let mut scene = Scene::new(Arc::clone(volume), graded.clone());
        scene.background = [0.1, 0.2, 0.3];
        scenes.push((
            format!("{name} nearest"),
            Scene { interpolation: Interpolation::Nearest, ..scene.clone() },
        ));
        scenes.push(((*name).to_string(), scene));
    }
    let with_nan = graded.with_nan([0.9, 0.1, 0.2, 0.3]).unwrap();
    let gaps = Scene::new(Arc::new(gaps::volume()), with_nan);
    scenes.push(("gaps".into(), gaps));
    let first = scenes[1].1.clone();
    let layer = Layer {
        volume: Arc::clone(&volumes[2].1),
        transfer_function: transfer().with_gradient(curve(&[[0.0, 1.0], [0.02, 1.0], [0.02, 0.2]])),
        colours: None,
        interpolation: Interpolation::Linear,
    };
    let plain = Scene { transfer_function: transfer(), ..first.clone() };
    scenes.push(("both".into(), Scene { layers: vec![layer.clone()], ..first.clone() }));
    scenes.push(("only the second".into(), Scene { layers: vec![layer.clone()], ..plain }));
    let colours = Some([0, 2, 0].map(|i| Arc::clone(&volumes[i].1)));
    scenes.push(("coloured".into(), Scene { colours, ..first }));
    scenes
}

fn drawn(scene: &Scene) -> Frame {
    let renderer = Renderer::new(scene, RenderOptions::default()).unwrap();
    renderer.march_full(&cameras()[0], FrameSize::new(93, 61).unwrap()).0
}

#[test]
fn every_instruction_set_agrees_with_the_specification() {
    let size = FrameSize::new(61, 43).unwrap();
    let scalar = RenderOptions { simd: Simd::Scalar, skip_empty: false };
    for (name, mut scene) in all() {
        for (shadows, surface) in [
            (ShadowMode::On, SurfaceShading::Flat),
            (ShadowMode::On, SurfaceShading::Gradient),
            (ShadowMode::Off, SurfaceShading::Flat),
            (ShadowMode::Cached, SurfaceShading::Flat),
        ] {
            (scene.shading.shadows, scene.shading.surface) = (shadows, surface);
            let mut renderer = Renderer::new(&scene, scalar).unwrap();
            for camera in cameras() {
                renderer.set_options(scalar);
                let (expected, _) = renderer.march_full(&camera, size);
                for (simd, skip_empty) in available_simd().into_iter().flat_map(|s| [(s, false), (s, true)]) {
                    renderer.set_options(RenderOptions { simd, skip_empty });
                    let (frame, _) = renderer.march_full(&camera, size);
                    let (p999, most, mean) = differences(&expected, &frame);
                    assert!(
                        p999 <= 1.0 / 255.0 && most <= 8.0 / 255.0 && mean <= 1e-3,
                        "{name} {shadows:?} {surface:?} {simd} skip {skip_empty}: {p999} {most} {mean}"
                    );
                }
            }
        }
    }
}

/// A ball whose inside and outside are homogeneous.
fn ball() -> Arc<Volume> {
    let grid = Grid::new([48; 3], [1.0; 3]).unwrap();
    let value = |i: usize| {
        let [x, y, z] = [i % 48, i / 48 % 48, i / 2304].map(|v| v as f64 - 23.5);
        ((20.0 - (x * x + y * y + z * z).sqrt()) * 0.25 + 0.5).clamp(0.0, 1.0) as f32
    };
    Arc::new(Volume::from_values(grid, (0..grid.voxels()).map(value).collect()).unwrap())
}

/// Haze of the opacity `most` at the value 1.
fn haze(most: f64) -> TransferFunction {
    let point = |value, opacity| ControlPoint::new(value, [1.0; 3], opacity);
    TransferFunction::new(vec![point(0.0, 0.0), point(1.0, most)]).unwrap()
}

#[test]
fn homogeneous_regions_vanish_and_borders_stay() {
    let scene = Scene::new(ball(), haze(0.2).with_gradient(curve(&[[0.05, 0.0], [0.1, 1.0]])));
    let renderer = Renderer::new(&scene, RenderOptions::default()).unwrap();
    let opacity = |x: f64| {
        let camera = Camera::at([x, 0.0, 2.0].into(), [x, 0.0, 0.0].into(), 1.0);
        let size = FrameSize::new(1, 1).unwrap();
        let pixel = fovol_core::Pixel { x: 0, y: 0 };
        let list = fovol_core::SampleList::new(size, vec![pixel]);
        renderer.march_list(&camera, &list).0[0].opacity
    };
    // In voxels of the opacity 0.1: two borders of four voxels, and one beside each where gradients end. The inside, 36
    // voxels of twice the opacity, is clear.
    let clear = 1.0 - f64::from(opacity(0.0));
    assert!((8.0..12.0).contains(&(clear.ln() / 0.9f64.ln())), "{clear}");
    // Near the rim a ray stays in the border.
    assert!(opacity(18.0 / 48.0) > opacity(0.0));
}

#[test]
fn a_constant_factor_scales_the_extinction() {
    let half = Scene::new(ball(), haze(0.75).with_gradient(curve(&[[0.0, 0.5]])));
    let constant = |a: f64| {
        let point = |value| ControlPoint::new(value, [1.0; 3], a);
        TransferFunction::new(vec![point(0.0), point(1.0)]).unwrap()
    };
    let half = Scene { transfer_function: constant(0.75).with_gradient(curve(&[[0.0, 0.5]])), ..half };
    let expected =
        Scene { transfer_function: constant(0.5), integration: Integration::Plain, ..half.clone() };
    for shadows in [ShadowMode::On, ShadowMode::Off, ShadowMode::Cached] {
        let [mut half, mut expected] = [half.clone(), expected.clone()];
        (half.shading.shadows, expected.shading.shadows) = (shadows, shadows);
        let (_, most, _) = differences(&drawn(&expected), &drawn(&half));
        assert!(most < 1e-3, "{shadows:?} {most}");
    }
}

#[test]
fn cached_shadows_follow_exact_ones() {
    for (name, mut scene) in all() {
        scene.shading.shadows = ShadowMode::On;
        let exact = drawn(&scene);
        scene.shading.shadows = ShadowMode::Cached;
        let (_, _, mean) = differences(&exact, &drawn(&scene));
        assert!(mean < 0.012, "{name}: {mean}");
    }
}

#[test]
fn neutral_factors_and_other_modes_change_nothing() {
    let plain = Scene { integration: Integration::Fine, ..Scene::new(ball(), haze(0.3)) };
    let with = |points| Scene { transfer_function: haze(0.3).with_gradient(curve(points)), ..plain.clone() };
    assert_eq!(drawn(&with(&[[0.0, 1.0], [0.3, 1.0]])).pixels(), drawn(&plain).pixels());
    let graded = with(&[[0.0, 0.0], [0.1, 1.0]]);
    assert_ne!(drawn(&graded).pixels(), drawn(&plain).pixels());
    for mode in [RayMode::Mip, RayMode::Minip, RayMode::Average, RayMode::Isosurface(0.5)] {
        let [graded, plain] = [&graded, &plain].map(|scene| drawn(&Scene { mode, ..scene.clone() }));
        assert_eq!(graded.pixels(), plain.pixels(), "{mode:?}");
    }
}

#[test]
fn changed_scenes_are_as_new_ones() {
    let (_, graded) = all().remove(1);
    let changes: [fn(&mut Scene); 6] = [
        |scene| scene.transfer_function = transfer(),
        |scene| scene.transfer_function = transfer().with_gradient(curve(&[[0.0, 0.0], [0.03, 1.0]])),
        |scene| scene.interpolation = Interpolation::Nearest,
        |scene| scene.mode = RayMode::Mip,
        |scene| scene.step = 1.0,
        |scene| scene.shading.shadows = ShadowMode::Cached,
    ];
    for shadows in [ShadowMode::On, ShadowMode::Cached] {
        for (number, change) in changes.iter().enumerate() {
            let mut before = graded.clone();
            before.shading.shadows = shadows;
            let mut after = before.clone();
            change(&mut after);
            for (from, to) in [(&before, &after), (&after, &before)] {
                let mut renderer = Renderer::new(from, RenderOptions::default()).unwrap();
                renderer.set_scene(to).unwrap();
                let size = FrameSize::new(93, 61).unwrap();
                let changed = renderer.march_full(&cameras()[0], size).0;
                assert_eq!(changed.pixels(), drawn(to).pixels(), "change {number}, {shadows:?}");
            }
        }
    }
}
