//! Projections, isosurfaces, parallel rays and clip planes: the fast marchers against the specification.

mod gaps;
mod scenes;
mod varied;

use fovol_core::{
    ControlPoint, FrameSize, Grid, Pixel, RayMode, SampleList, Scene, TransferFunction, Volume,
};
use fovol_render::cpu::{RenderOptions, Renderer, Simd, available_simd};
use scenes::differences;
use std::sync::Arc;

#[test]
fn every_instruction_set_agrees_with_the_specification() {
    let size = FrameSize::new(93, 61).unwrap();
    let scalar = RenderOptions { simd: Simd::Scalar, skip_empty: false };
    varied::scenes(|name, scene, cameras| {
        let mut renderer = Renderer::new(scene, scalar).unwrap();
        for camera in cameras {
            renderer.set_options(scalar);
            let (expected, _) = renderer.march_full(camera, size);
            for simd in available_simd() {
                for skip_empty in [false, true] {
                    renderer.set_options(RenderOptions { simd, skip_empty });
                    let (frame, _) = renderer.march_full(camera, size);
                    let (p999, most, mean) = differences(&expected, &frame);
                    assert!(
                        p999 <= 1.0 / 255.0 && most <= varied::MOST && mean <= 1e-3,
                        "{name} {simd} skip {skip_empty}: {p999} {most} {mean}"
                    );
                }
            }
        }
    });
}

/// Rays change their mode with their scene, and the shadows of composited pictures come back.
#[test]
fn a_changed_mode_is_as_a_new_one() {
    let size = FrameSize::new(48, 32).unwrap();
    let pixels: Vec<Pixel> = (0..32).flat_map(|y| (0..48).map(move |x| Pixel { x, y })).collect();
    let list = SampleList::new(size, pixels);
    let mut scene = Scene::new(Arc::new(scenes::volumes().remove(0).1), scenes::transfer());
    let camera = scenes::cameras()[0];
    let mut changed = Renderer::new(&scene, RenderOptions::default()).unwrap();
    for mode in
        [RayMode::Isosurface(0.3), RayMode::Composite, RayMode::Average, RayMode::Mip, RayMode::Composite]
    {
        scene.mode = mode;
        changed.set_scene(&scene).unwrap();
        let anew = Renderer::new(&scene, RenderOptions::default()).unwrap();
        assert_eq!(changed.march_list(&camera, &list), anew.march_list(&camera, &list), "{mode:?}");
    }
}

/// A cube in which voxel x holds 10·x, seen along x.
#[test]
fn projections_show_the_greatest_the_least_and_the_mean() {
    let grid = Grid::new([20; 3], [1.0; 3]).unwrap();
    let values = (0..grid.voxels()).map(|i| (10 * (i % 20)) as f32).collect();
    let volume = Volume::from_values(grid, values).unwrap();
    let point = |at, grey: f64| ControlPoint::new(at, [grey; 3], 0.5);
    let ramp = TransferFunction::new(vec![point(0.0, 0.0), point(1.0, 1.0)]).unwrap();
    let mut scene = Scene::new(Arc::new(volume), ramp);
    scene.background = [1.0, 0.0, 0.0];
    let camera = fovol_core::Camera::new([2.0, 0.0, 0.0].into(), [0.0; 3].into(), 10.0).unwrap();
    let list = SampleList::new(FrameSize::new(9, 9).unwrap(), vec![Pixel { x: 4, y: 4 }]);
    for (mode, grey, depth) in
        [(RayMode::Mip, 1.0, 1.5), (RayMode::Minip, 0.0, 2.5), (RayMode::Average, 0.5, 2.0)]
    {
        scene.mode = mode;
        let renderer = Renderer::new(&scene, RenderOptions::default()).unwrap();
        let found = renderer.march_list(&camera, &list).0[0];
        assert!((found.opacity - 0.5).abs() < 1e-6, "{mode:?} {found:?}");
        for (colour, right) in found.colour.into_iter().zip([0.5 * grey + 0.5, 0.5 * grey, 0.5 * grey]) {
            assert!((colour - right).abs() < 2e-3, "{mode:?} {found:?}");
        }
        assert!((found.depth - depth).abs() < 0.06, "{mode:?} {found:?}");
    }
}

/// A ball's surface lies where its values say, is dark on the far side of the light, and its shadow falls on a wall.
#[test]
fn isosurfaces_lie_at_their_value_and_cast_shadows() {
    let grid = Grid::new([64; 3], [1.0; 3]).unwrap();
    let ball = |i: usize| {
        let [x, y, z] = [i % 64, i / 64 % 64, i / 4096].map(|c| (c as f32 + 0.5) / 64.0 - 0.5);
        let from_ball = 0.2 - (x * x + y * y + z * z).sqrt();
        // A wall across z, behind the ball.
        from_ball.max(-0.4 - z)
    };
    let volume = Volume::from_values(grid, (0..grid.voxels()).map(ball).collect()).unwrap();
    let white = TransferFunction::new(vec![ControlPoint::new(0.0, [1.0; 3], 0.0)]).unwrap();
    let iso = volume.normalised(0.0) as f32;
    let mut scene = Scene { mode: RayMode::Isosurface(iso), ..Scene::new(Arc::new(volume), white) };
    scene.shading.light = fovol_core::Light::towards([1.0, 0.0, 1.0].into()).unwrap();
    scene.shading.ambient = 0.1;
    let camera = fovol_core::Camera::new([0.0, 0.0, 2.0].into(), [0.0; 3].into(), 30.0).unwrap();
    let size = FrameSize::new(101, 101).unwrap();
    let renderer = Renderer::new(&scene, RenderOptions::default()).unwrap();
    let seen = |x: u32, y: u32| {
        let list = SampleList::new(size, vec![Pixel { x: x as u16, y: y as u16 }]);
        renderer.march_list(&camera, &list).0[0]
    };
    let middle = seen(50, 50);
    assert!((middle.depth - 1.8).abs() < 2e-3, "{middle:?}");
    let lit = 0.1 + 0.9 * std::f32::consts::FRAC_1_SQRT_2;
    assert!((middle.colour[0] - lit).abs() < 0.01 && middle.opacity == 1.0, "{middle:?}");
    // The wall is 2.4 away and faces the eye as the ball's middle does.
    let wall = seen(80, 20);
    let ray = camera.rays(size).ray(80, 20);
    assert!((wall.depth * -ray.direction.z as f32 - 2.4).abs() < 3e-3, "{wall:?}");
    assert!((wall.colour[0] - lit).abs() < 0.01, "{wall:?}");
    // The shadow lies 0.4 to the left of the ball: at x = −0.4, where the eye looks past the ball.
    let x = 50.5 - 0.4 / 2.4 / 15f64.to_radians().tan() * 50.5;
    let shadow = seen(x as u32, 50);
    assert!((shadow.colour[0] - 0.1).abs() < 1e-6 && (shadow.unshadowed[0] - lit).abs() < 0.01, "{shadow:?}");
    scene.shading.shadows = fovol_core::ShadowMode::Off;
    let unlit = Renderer::new(&scene, RenderOptions::default()).unwrap();
    let list = SampleList::new(size, vec![Pixel { x: x as u16, y: 50 }]);
    assert!((unlit.march_list(&camera, &list).0[0].colour[0] - lit).abs() < 0.01);
}
