//! The fast marchers against the specification.

use fovol_core::{
    Camera, CameraPath, ControlPoint, Frame, FrameSize, Grid, Light, Pixel, SampleList, Scene, ShadowMode,
    SurfaceShading, TransferFunction, Volume,
};
use fovol_render::cpu::{RenderOptions, Renderer, Simd};
use std::sync::Arc;

/// A dented ball with a hollow and a surrounding haze, as values of 0…1.
fn ball(dims: [usize; 3]) -> Vec<f64> {
    let centred = |i: usize, n: usize| (i as f64 + 0.5) / n as f64 * 2.0 - 1.0;
    let mut values = Vec::new();
    for z in 0..dims[2] {
        for y in 0..dims[1] {
            for x in 0..dims[0] {
                let (x, y, z) = (centred(x, dims[0]), centred(y, dims[1]), centred(z, dims[2]));
                let r = (x * x + y * y + z * z).sqrt() + 0.08 * (9.0 * x).sin() * (7.0 * y).cos();
                let shell = (-((r - 0.6) / 0.15).powi(2)).exp();
                values.push((0.8 * shell + 0.15 * (-4.0 * (r - 0.2).powi(2)).exp()).clamp(0.0, 1.0));
            }
        }
    }
    values
}

fn volumes() -> Vec<(&'static str, Volume)> {
    let cube = Grid::new([45, 38, 50], [1.0; 3]).unwrap();
    let flat = Grid::new([40, 33, 17], [0.7, 0.9, 2.5]).unwrap();
    let bytes = ball(cube.dims()).iter().map(|v| (v * 255.0) as u8).collect();
    let shorts = ball(flat.dims()).iter().map(|v| (v * 4000.0) as i16 - 1024).collect();
    let floats = ball(cube.dims()).iter().map(|v| (v * 3.7 - 1.0) as f32).collect();
    vec![
        ("u8", Volume::from_values(cube, bytes).unwrap()),
        ("i16, anisotropic", Volume::from_values(flat, shorts).unwrap()),
        ("f32", Volume::from_values(cube, floats).unwrap()),
    ]
}

fn transfer() -> TransferFunction {
    let p = ControlPoint::new;
    TransferFunction::new(vec![
        p(0.0, [0.1, 0.2, 0.6], 0.0),
        p(0.25, [0.2, 0.4, 0.9], 0.0),
        p(0.4, [0.9, 0.6, 0.2], 0.08),
        p(0.7, [1.0, 0.9, 0.7], 0.6),
        p(1.0, [1.0, 1.0, 1.0], 0.9),
    ])
    .unwrap()
}

/// 99.9th percentile, maximum and mean of the channel differences.
fn differences(a: &Frame, b: &Frame) -> (f32, f32, f64) {
    let mut all: Vec<f32> = a
        .pixels()
        .iter()
        .zip(b.pixels())
        .flat_map(|(a, b)| (0..3).map(move |c| (a[c] - b[c]).abs()))
        .collect();
    all.sort_by(f32::total_cmp);
    let mean = all.iter().map(|&d| f64::from(d)).sum::<f64>() / all.len() as f64;
    (all[all.len() * 999 / 1000], all[all.len() - 1], mean)
}

/// From outside, from inside the box, and along an axis (two components of the direction near 0).
fn cameras() -> [Camera; 3] {
    [
        CameraPath::Orbit.camera(70),
        Camera::on_sphere(200.0, 10.0, 0.3, 70.0),
        Camera::on_sphere(0.0, 0.0, 1.9, 35.0),
    ]
}

#[test]
fn every_instruction_set_agrees_with_the_specification() {
    let size = FrameSize::new(93, 61).unwrap();
    for (name, volume) in volumes() {
        let mut scene = Scene::new(Arc::new(volume), transfer());
        scene.background = [0.1, 0.2, 0.3];
        for shadows in [ShadowMode::On, ShadowMode::Off, ShadowMode::Cached] {
            for surface in [SurfaceShading::Flat, SurfaceShading::Gradient] {
                scene.shading.shadows = shadows;
                scene.shading.surface = surface;
                let scalar = RenderOptions { simd: Simd::Scalar, skip_empty: false };
                let mut renderer = Renderer::new(&scene, scalar).unwrap();
                for camera in cameras() {
                    renderer.set_options(scalar);
                    let (expected, _) = renderer.march_full(&camera, size);
                    for simd in Simd::available() {
                        for skip_empty in [false, true] {
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
            for simd in Simd::available() {
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
fn a_changed_transfer_function_or_light_shows_at_once() {
    let (_, volume) = volumes().remove(0);
    let mut scene = Scene::new(Arc::new(volume), transfer());
    scene.shading.shadows = ShadowMode::Cached;
    let size = FrameSize::new(64, 64).unwrap();
    let camera = CameraPath::Orbit.camera(0);
    let mut changed = Renderer::new(&scene, RenderOptions::default()).unwrap();
    scene.transfer_function = TransferFunction::grey_ramp(0.3);
    scene.shading.light = Light::towards([-1.0, 0.2, 0.0].into()).unwrap();
    changed.set_transfer_function(&scene.transfer_function);
    changed.set_shading(scene.shading);
    let fresh = Renderer::new(&scene, RenderOptions::default()).unwrap();
    assert_eq!(changed.march_full(&camera, size).0, fresh.march_full(&camera, size).0);
}

#[test]
fn one_voxel_and_thin_volumes_render() {
    for dims in [[1, 1, 1], [1, 30, 2], [17, 1, 1], [2, 2, 2]] {
        let grid = Grid::new(dims, [1.0; 3]).unwrap();
        let volume = Volume::from_values(grid, vec![200u8; grid.voxels()]).unwrap();
        let scene = Scene::new(Arc::new(volume), TransferFunction::grey_ramp(0.9));
        for simd in Simd::available() {
            let renderer = Renderer::new(&scene, RenderOptions { simd, skip_empty: true }).unwrap();
            let (frame, count) =
                renderer.march_full(&CameraPath::Orbit.camera(0), FrameSize::new(41, 31).unwrap());
            assert!(count.primary > 0 && frame.pixel(20, 15)[0] > 0.1, "{dims:?} {simd}");
        }
    }
}
