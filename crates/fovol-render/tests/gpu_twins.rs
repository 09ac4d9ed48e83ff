//! The GPU against the specification.
//!
//! These tests need an adapter, a software one included: `cargo test --workspace -- --ignored`. On Debian
//! `apt-get install mesa-vulkan-drivers libvulkan1` is one.
#![cfg(feature = "gpu")]

mod gpu_frames;
mod scenes;

use fovol_core::{
    Camera, CameraPath, Fovea, Frame, FrameSize, Grid, Integration, Light, Pixel, SampleList, Scene,
    ShadowMode, SurfaceShading, TransferFunction, Volume,
};
use fovol_gpu::{AdapterRequest, Gpu, GpuError};
use fovol_render::Filtering;
use fovol_render::cpu::{self, RenderOptions, Simd};
use fovol_render::gpu::{Error, MaskSource, Renderer, Sampling, Stage};
use fovol_render::noise::{Noise, NoiseKind};
use fovol_render::scene::RayResult;
use gpu_frames::{GPU, full_frame, small_scene};
use proptest::prelude::*;
use scenes::{cameras, differences, transfer, volumes};
use std::sync::{Arc, LazyLock};

const SCALAR: RenderOptions = RenderOptions { simd: Simd::Scalar, skip_empty: false };

/// Asserts that pictures of `scene` in every shading and from every camera match the specification.
fn agrees_with_the_specification(gpu: &Gpu, name: &str, mut scene: Scene) {
    let size = FrameSize::new(93, 61).unwrap();
    let mut gpu_renderer = Renderer::new(gpu, &scene).unwrap();
    let mut cpu_renderer = cpu::Renderer::new(&scene, SCALAR).unwrap();
    let mut buffers = gpu_renderer.frame_buffers(size).unwrap();
    for shadows in [ShadowMode::On, ShadowMode::Off, ShadowMode::Cached] {
        for surface in [SurfaceShading::Flat, SurfaceShading::Gradient] {
            scene.shading.shadows = shadows;
            scene.shading.surface = surface;
            cpu_renderer.set_scene(&scene).unwrap();
            gpu_renderer.set_scene(&scene).unwrap();
            for camera in cameras() {
                let (expected, _) = cpu_renderer.march_full(&camera, size);
                for skip_empty in [false, true] {
                    gpu_renderer.set_skip_empty(skip_empty);
                    let frame = full_frame(&gpu_renderer, &mut buffers, &camera);
                    let (p999, most, mean) = differences(&expected, &frame);
                    assert!(
                        most <= 2.0 / 255.0 && mean <= 2e-3,
                        "{name} {shadows:?} {surface:?} skip {skip_empty}: {p999} {most} {mean}"
                    );
                }
            }
        }
    }
}

#[test]
#[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
fn pictures_are_those_of_the_specification() {
    for (name, volume) in volumes() {
        let volume = Arc::new(volume);
        for integration in [Integration::Plain, Integration::Fine] {
            let mut scene = Scene::new(Arc::clone(&volume), transfer());
            scene.background = [0.1, 0.2, 0.3];
            scene.integration = integration;
            agrees_with_the_specification(&GPU, &format!("{name}, {integration}"), scene);
        }
    }
}

/// A volume of noise between `low` and `high`, whose borders show as well.
fn noise(dims: [usize; 3], spacing: [f64; 3], [low, high]: [f64; 2], seed: u64) -> Volume {
    let grid = Grid::new(dims, spacing).unwrap();
    let random =
        |i: u64| (i.wrapping_add(seed).wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 40) as f64 / f64::from(1 << 24);
    let values = (0..grid.voxels() as u64).map(|i| (low + (high - low) * random(i * i + i)) as f32).collect();
    Volume::from_values(grid, values).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, failure_persistence: None, ..Default::default() })]
    #[test]
    #[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
    fn any_scene_looks_as_the_specification_says(
        dims in prop::array::uniform3(1usize..24), spacing in prop::array::uniform3(0.5f64..2.0), seed in 0u64..1000,
        eye in prop::array::uniform3(-1.5f64..1.5), target in prop::array::uniform3(-0.2f64..0.2),
        fovy in 20.0f64..100.0, light in prop::array::uniform3(-1i32..=1), step in 0.2f64..2.0,
        opacity in 0.0f64..=1.0, shadows in 0usize..3, gradient in any::<bool>(), axis in 0usize..4, fine in any::<bool>(),
    ) {
        let mut scene = Scene::new(Arc::new(noise(dims, spacing, [0.0, 1.0], seed)), TransferFunction::grey_ramp(opacity));
        scene.step = step;
        scene.integration = if fine { Integration::Fine } else { Integration::Plain };
        scene.background = [0.2, 0.0, 0.4];
        scene.shading.shadows = [ShadowMode::On, ShadowMode::Off, ShadowMode::Cached][shadows];
        scene.shading.surface = if gradient { SurfaceShading::Gradient } else { SurfaceShading::Flat };
        // Also along axes, and parallel to faces.
        let light = if light == [0; 3] { [0, 0, 1] } else { light };
        scene.shading.light = Light::towards(light.map(f64::from).into()).unwrap();
        let mut eye = eye;
        if axis < 3 {
            eye = [0.0; 3];
            eye[axis] = 1.4;
        }
        let target = if axis < 3 { [0.0; 3] } else { target };
        let camera = Camera::new(eye.into(), target.into(), fovy).unwrap();
        let size = FrameSize::new(41, 31).unwrap();
        let (expected, _) = cpu::Renderer::new(&scene, SCALAR).unwrap().march_full(&camera, size);
        let renderer = Renderer::new(&GPU, &scene).unwrap();
        let mut buffers = renderer.frame_buffers(size).unwrap();
        let (p999, most, mean) = differences(&expected, &full_frame(&renderer, &mut buffers, &camera));
        // A last sample at a face of the box may fall either way.
        prop_assert!(p999 <= 2.0 / 255.0 && most <= 8.0 / 255.0 && mean <= 2e-3, "{p999} {most} {mean}");
    }
}

#[test]
#[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
fn large_volumes_are_stored_another_way_and_look_the_same() {
    let dims = [[2048, 2048, 17], [2048, 1024, 17], [1024, 1024, 17]];
    let value = |i: usize| (i * 7 % 251 + i / 2048 * 3 % 97) % 256;
    let grids = dims.map(|dims| Grid::new(dims, [1.0, 1.0, 4.0]).unwrap());
    let volumes = [
        Volume::from_values(grids[0], (0..grids[0].voxels()).map(|i| value(i) as u8).collect()).unwrap(),
        Volume::from_values(grids[1], (0..grids[1].voxels()).map(|i| value(i) as u16 * 200).collect())
            .unwrap(),
        Volume::from_values(grids[2], (0..grids[2].voxels()).map(|i| value(i) as f32 * 0.1).collect())
            .unwrap(),
    ];
    let size = FrameSize::new(41, 31).unwrap();
    let camera = Camera::on_sphere(30.0, 20.0, 0.1, 50.0);
    for volume in volumes {
        let name = volume.dtype();
        let mut scene = Scene::new(Arc::new(volume), TransferFunction::grey_ramp(0.05));
        scene.shading.shadows = ShadowMode::Off;
        let (expected, _) = cpu::Renderer::new(&scene, SCALAR).unwrap().march_full(&camera, size);
        let renderer = Renderer::new(&GPU, &scene).unwrap();
        let mut buffers = renderer.frame_buffers(size).unwrap();
        let (_, most, mean) = differences(&expected, &full_frame(&renderer, &mut buffers, &camera));
        assert!(most <= 2.0 / 255.0 && mean <= 2e-3, "{name}: {most} {mean}");
        assert!(expected.pixels().iter().any(|p| p[0] > 0.1), "{name}: nothing is seen");
    }
}

/// Whether texture samplers of `gpu` filter volumes of bytes, of 16 bits and of floats; asserts that their pictures
/// agree with exact filtering.
fn filtered_by_samplers(gpu: &Gpu) -> [bool; 3] {
    let dims = [40, 30, 20];
    let grid = Grid::new(dims, [1.0; 3]).unwrap();
    let wave = |i: usize| {
        let at = [i % 40, i / 40 % 30, i / 1200].map(|n| n as f64 * 0.3);
        0.5 + 0.5 * (at[0].sin() * at[1].cos() * (at[2] + 1.0).sin())
    };
    let values = |most: f64| (0..grid.voxels()).map(move |i| wave(i) * most);
    let volumes = [
        Volume::from_values(grid, values(255.0).map(|v| v as u8).collect()).unwrap(),
        Volume::from_values(grid, values(60_000.0).map(|v| v as u16).collect()).unwrap(),
        Volume::from_values(grid, values(7.0).map(|v| v as f32).collect()).unwrap(),
    ];
    volumes.map(|volume| {
        let name = volume.dtype();
        let mut scene = Scene::new(Arc::new(volume), transfer());
        let filtered = Renderer::with_filtering(gpu, &scene, Filtering::Hardware).unwrap();
        let is_filtered = filtered.filtering() == Filtering::Hardware;
        let mut renderers = [Renderer::new(gpu, &scene).unwrap(), filtered];
        let size = FrameSize::new(64, 48).unwrap();
        for shadows in [ShadowMode::On, ShadowMode::Cached] {
            scene.shading.shadows = shadows;
            let frames = renderers.each_mut().map(|renderer| {
                renderer.set_scene(&scene).unwrap();
                let mut buffers = renderer.frame_buffers(size).unwrap();
                full_frame(renderer, &mut buffers, &cameras()[0])
            });
            let (_, most, mean) = differences(&frames[0], &frames[1]);
            println!("{name} {shadows:?}: at most {most:.1e}, {mean:.1e} in the mean");
            assert!(most <= 8.0 / 255.0 && mean <= 2e-3, "{name} {shadows:?}: {most} {mean}");
            assert!(is_filtered || most == 0.0, "{name}");
        }
        is_filtered
    })
}

#[test]
#[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
fn samplers_filter_where_they_can() {
    let has = |feature| GPU.device().features().contains(feature);
    let can = [wgpu::Features::TEXTURE_FORMAT_16BIT_NORM, wgpu::Features::FLOAT32_FILTERABLE].map(has);
    assert_eq!(filtered_by_samplers(&GPU), [true, can[0], can[1]]);
    assert_eq!(filtered_by_samplers(&baseline_gpu()), [true, false, false]);
}

#[test]
#[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
fn eyes_far_beyond_everything_see_something_or_nothing_but_do_not_hang() {
    let renderer = &SAMPLED.renderer;
    let mut buffers = renderer.frame_buffers(FrameSize::new(16, 9).unwrap()).unwrap();
    for far in [1e3, 1e9, 1e30, 1e150] {
        let camera = Camera::new([0.1 * far, 0.2 * far, far].into(), [0.0; 3].into(), 35.0).unwrap();
        let frame = full_frame(renderer, &mut buffers, &camera);
        assert!(frame.pixels().iter().flatten().all(|c| c.is_finite()), "{far}");
    }
}

/// A device with the limits of every WebGPU, and nothing else.
fn baseline_gpu() -> Gpu {
    Gpu::open_baseline(&AdapterRequest::Any.or_environment()).unwrap()
}

#[test]
#[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
fn what_every_webgpu_has_is_enough() {
    let gpu = baseline_gpu();
    agrees_with_the_specification(&gpu, "baseline", small_scene());
    let renderer = Renderer::new(&gpu, &small_scene()).unwrap();
    let mut buffers = renderer.frame_buffers(FrameSize::new(20, 10).unwrap()).unwrap();
    full_frame(&renderer, &mut buffers, &cameras()[0]);
    assert_eq!(buffers.read_times().unwrap(), None, "it has no timestamps");
}

#[test]
#[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
fn too_much_for_the_device_is_refused_with_the_limit() {
    let gpu = baseline_gpu();
    let long = Grid::new([3000, 1, 1], [1.0; 3]).unwrap();
    let volume = Volume::from_values(long, vec![9u8; 3000]).unwrap();
    let scene = Scene::new(Arc::new(volume), transfer());
    let error = Renderer::new(&gpu, &scene).unwrap_err();
    assert!(matches!(error, Error::Gpu(GpuError::Limit { needed: 3000, allowed: 2048, .. })), "{error}");
    let renderer = Renderer::new(&gpu, &small_scene()).unwrap();
    let error = renderer.frame_buffers(FrameSize::new(8192, 4320).unwrap()).unwrap_err();
    assert!(error.to_string().contains("maxStorageBufferBindingSize"), "{error}");
}

#[test]
#[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
fn a_lost_device_is_an_error() {
    let gpu = Gpu::open(&AdapterRequest::Any.or_environment()).unwrap();
    let mut renderer = Renderer::new(&gpu, &small_scene()).unwrap();
    let mut buffers = renderer.frame_buffers(FrameSize::new(20, 10).unwrap()).unwrap();
    gpu.device().destroy();
    let rendered = renderer.render(&mut buffers, &cameras()[0], Sampling::Full);
    let read = buffers.read_frame();
    assert!(rendered.is_err() || read.is_err(), "a picture of a device that is gone");
    assert!(read.is_err());
    // None of these may panic, whatever they return.
    let _ = renderer.set_scene(&Scene { step: 0.7, ..small_scene() });
    let _ = renderer.frame_buffers(FrameSize::new(20, 10).unwrap());
    let _ = Renderer::new(&gpu, &small_scene());
    let _ = gpu.wait();
}

#[test]
#[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
fn samples_of_a_list_are_those_of_the_specification() {
    let size = FrameSize::new(93, 61).unwrap();
    let pixels: Vec<Pixel> = (0..61).flat_map(|y| (0..93).map(move |x| Pixel { x, y })).collect();
    let list = SampleList::new(size, pixels);
    for (name, volume) in volumes() {
        let mut scene = Scene::new(Arc::new(volume), transfer());
        samples_agree(name, &scene, &list);
        scene.integration = Integration::Plain;
        scene.shading.surface = SurfaceShading::Gradient;
        samples_agree(name, &scene, &list);
    }
}

/// Asserts that the samples of `list` in `scene` are those of the specification.
fn samples_agree(name: &str, scene: &Scene, list: &SampleList) {
    let expected_by = cpu::Renderer::new(scene, SCALAR).unwrap();
    let renderer = Renderer::new(&GPU, scene).unwrap();
    let mut buffers = renderer.frame_buffers(list.size()).unwrap();
    let step = 0.5 * scene.volume.grid().smallest_voxel() as f32;
    for camera in cameras() {
        let (expected, _) = expected_by.march_list(&camera, list);
        renderer.render(&mut buffers, &camera, Sampling::List(list)).unwrap();
        let found = buffers.read_samples().unwrap();
        assert_eq!(found.len(), expected.len());
        let inverse_depths = buffers.read_inverse_depths().unwrap();
        let (mut far, mut off) = (0, 0);
        for ((expected, found), inverse) in expected.iter().zip(&found).zip(inverse_depths) {
            assert!((expected.opacity - found.opacity).abs() < 2.0 / 255.0, "{name}: {expected:?} {found:?}");
            let differs = |of: fn(&RayResult) -> [f32; 3]| {
                (0..3).any(|c| (of(expected)[c] - of(found)[c]).abs() >= 2.0 / 255.0)
            };
            off += usize::from(differs(|ray| ray.colour) || differs(|ray| ray.unshadowed));
            assert_eq!(inverse > 0.0, found.depth.is_finite());
            let agrees = expected.depth == found.depth
                || (expected.depth - found.depth).abs() <= 1.01 * step + 1e-4 * expected.depth;
            far += usize::from(!agrees && expected.opacity > 0.01);
        }
        // Gradients that are nearly 0 may point anywhere.
        let most = if scene.shading.surface == SurfaceShading::Gradient { found.len() / 500 } else { 0 };
        assert!(off <= most, "{name}: {off}");
        // At the edges of thin things one half may be passed at the front or at the back.
        assert!(far * 500 <= found.len(), "{name}: {far}");
    }
}

/// Renderers of the small scene, shared by the tests of masks, lists and sparse frames.
struct Sampled {
    renderer: Renderer,
    full: Renderer,
}

static SAMPLED: LazyLock<Sampled> = LazyLock::new(|| Sampled {
    renderer: Renderer::new(&GPU, &small_scene()).unwrap(),
    full: Renderer::new(&GPU, &small_scene()).unwrap(),
});

proptest! {
    #![proptest_config(ProptestConfig { cases: 30, failure_persistence: None, ..Default::default() })]
    #[test]
    #[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
    fn masks_and_lists_are_those_of_the_cpu(
        w in 1u32..300, h in 1u32..150, base in 0.0f64..1.0, sigma in 0.0f64..0.3,
        gx in -0.2f64..1.2, gy in -0.2f64..1.2, t in 0u32..200, kind in 0usize..3,
    ) {
        let size = FrameSize::new(w, h).unwrap();
        let fovea = Fovea { base: base * base, sigma, gaze: [gx, gy] };
        let noise = Noise::new(NoiseKind::ALL[kind], 3);
        let camera = cameras()[0];
        let mut buffers = SAMPLED.renderer.frame_buffers(size).unwrap();
        let source = MaskSource { fovea: &fovea, noise: &noise, frame: t };
        SAMPLED.renderer.render(&mut buffers, &camera, Sampling::Compact(source)).unwrap();
        let mask = cpu::mask(&fovea, size, &noise, t);
        prop_assert_eq!(buffers.read_mask().unwrap(), mask.clone());
        prop_assert_eq!(buffers.read_list().unwrap(), cpu::compact(&mask));
    }
}

#[test]
#[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
fn the_papers_masks_are_those_of_the_cpu_in_every_frame() {
    let size = FrameSize::new(640, 360).unwrap();
    let grid = Grid::new([1, 1, 1], [1.0; 3]).unwrap();
    let volume = Volume::from_values(grid, vec![0u8]).unwrap();
    let renderer = Renderer::new(&GPU, &Scene::new(Arc::new(volume), transfer())).unwrap();
    let mut buffers = renderer.frame_buffers(size).unwrap();
    let noise = Noise::new(NoiseKind::Stbn, 0);
    for t in 0..64 {
        // The gaze moves, and the fovea grows and shrinks.
        let at = f64::from(t) / 64.0;
        let fovea = if t % 2 == 0 { (0.03, 0.02) } else { (0.07, 0.06) };
        let fovea = Fovea { base: fovea.0, sigma: fovea.1, gaze: [at, 1.0 - at] };
        let source = MaskSource { fovea: &fovea, noise: &noise, frame: t };
        renderer.render(&mut buffers, &cameras()[0], Sampling::Compact(source)).unwrap();
        let mask = cpu::mask(&fovea, size, &noise, t);
        assert_eq!(buffers.read_mask().unwrap(), mask, "frame {t}");
        assert_eq!(buffers.read_list().unwrap(), cpu::compact(&mask), "frame {t}");
    }
}

#[test]
#[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
fn every_way_to_sample_gives_the_pixels_of_the_full_frame() {
    let size = FrameSize::new(150, 84).unwrap();
    let fovea = Fovea { base: 0.1, sigma: 0.1, gaze: [0.4, 0.6] };
    let (renderer, noise) = (&SAMPLED.full, Noise::new(NoiseKind::Stbn, 0));
    let camera = cameras()[0];
    let mut buffers = renderer.frame_buffers(size).unwrap();
    let full = full_frame(renderer, &mut buffers, &camera);
    let depths = buffers.read_inverse_depths().unwrap();
    assert!(full.pixels().iter().all(|p| p[3] == 1.0));
    let source = MaskSource { fovea: &fovea, noise: &noise, frame: 5 };
    let mask = cpu::mask(&fovea, size, &noise, 5);
    let drawn = cpu::direct(&fovea, size, 7, 5);
    let drawn_mask = cpu::mask_of(&drawn.list);
    let ways = [
        (Sampling::Reject(source), &mask),
        (Sampling::Compact(source), &mask),
        (Sampling::List(&drawn.list), &drawn_mask),
    ];
    for (sampling, mask) in ways {
        renderer.render(&mut buffers, &camera, sampling).unwrap();
        let sparse = buffers.read_frame().unwrap();
        let sparse_depths = buffers.read_inverse_depths().unwrap();
        for (i, (pixel, whole)) in sparse.pixels().iter().zip(full.pixels()).enumerate() {
            let (x, y) = (i as u32 % size.width, i as u32 / size.width);
            if mask.contains(x, y) {
                assert!(
                    (0..4).all(|c| (pixel[c] - whole[c]).abs() < 1e-5),
                    "{sampling:?} {x},{y}: {pixel:?} {whole:?}"
                );
                assert!((sparse_depths[i] - depths[i]).abs() < 1e-5);
            } else {
                assert_eq!((*pixel, sparse_depths[i]), ([0.0; 4], 0.0), "{sampling:?} {x},{y}");
            }
        }
    }
}

#[test]
#[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
fn whatever_uses_a_frame_can_follow_in_the_same_submission() {
    let size = FrameSize::new(40, 30).unwrap();
    let (renderer, camera) = (&SAMPLED.renderer, cameras()[0]);
    let mut buffers = renderer.frame_buffers(size).unwrap();
    let expected = full_frame(renderer, &mut buffers, &camera);
    renderer.render(&mut buffers, &cameras()[1], Sampling::Full).unwrap();
    // Stands for a network: it reads what has just been rendered.
    let reader = renderer.frame_buffers(size).unwrap();
    let mut encoder = GPU.device().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    renderer.encode(&mut encoder, &mut buffers, &camera, Sampling::Full).unwrap();
    encoder.copy_buffer_to_buffer(buffers.frame(), 0, reader.frame(), 0, None);
    GPU.enqueue([encoder.finish()]);
    assert_eq!(reader.read_frame().unwrap(), expected);
}

#[test]
#[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
fn lists_that_do_not_fit_are_refused() {
    let renderer = &SAMPLED.renderer;
    let [small, large] = [[4, 4], [5, 4]].map(|[w, h]| FrameSize::new(w, h).unwrap());
    let mut buffers = renderer.frame_buffers(small).unwrap();
    let other = SampleList::new(large, vec![Pixel { x: 4, y: 3 }]);
    let refused = renderer.render(&mut buffers, &cameras()[0], Sampling::List(&other));
    assert_eq!(refused, Err(Error::Size { list: large, frame: small }));
    let long = SampleList::new(small, vec![Pixel { x: 0, y: 0 }; 17]);
    let refused = renderer.render(&mut buffers, &cameras()[0], Sampling::List(&long));
    assert!(
        matches!(refused, Err(Error::Gpu(GpuError::Limit { needed: 17, allowed: 16, .. }))),
        "{refused:?}"
    );
    let empty = SampleList::new(small, Vec::new());
    renderer.render(&mut buffers, &cameras()[0], Sampling::List(&empty)).unwrap();
    assert_eq!(buffers.read_frame().unwrap(), Frame::new(small));
    assert!(buffers.read_samples().unwrap().is_empty());
}

#[test]
#[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
fn a_changed_scene_shows_at_once() {
    let mut scene = small_scene();
    scene.shading.shadows = ShadowMode::Cached;
    let size = FrameSize::new(64, 64).unwrap();
    let mut changed = Renderer::new(&GPU, &scene).unwrap();
    scene.transfer_function = TransferFunction::grey_ramp(0.3);
    scene.shading.light = Light::towards([-1.0, 0.2, 0.0].into()).unwrap();
    scene.background = [0.2, 0.3, 0.4];
    scene.step = 0.8;
    changed.set_scene(&scene).unwrap();
    let fresh = Renderer::new(&GPU, &scene).unwrap();
    let mut buffers = fresh.frame_buffers(size).unwrap();
    let expected = full_frame(&fresh, &mut buffers, &cameras()[0]);
    assert_eq!(full_frame(&changed, &mut buffers, &cameras()[0]), expected);
}

#[test]
#[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
fn one_voxel_and_thin_volumes_render() {
    for dims in [[1, 1, 1], [1, 30, 2], [17, 1, 1], [2, 2, 2]] {
        let grid = Grid::new(dims, [1.0; 3]).unwrap();
        let volume = Volume::from_values(grid, vec![200u8; grid.voxels()]).unwrap();
        let scene = Scene::new(Arc::new(volume), TransferFunction::grey_ramp(0.9));
        let size = FrameSize::new(41, 31).unwrap();
        let camera = CameraPath::Orbit.camera(0);
        let renderer = Renderer::new(&GPU, &scene).unwrap();
        let mut buffers = renderer.frame_buffers(size).unwrap();
        let frame = full_frame(&renderer, &mut buffers, &camera);
        let (expected, _) = cpu::Renderer::new(&scene, SCALAR).unwrap().march_full(&camera, size);
        let (_, most, mean) = differences(&expected, &frame);
        assert!(most <= 2.0 / 255.0 && mean <= 2e-3, "{dims:?}: {most} {mean}");
    }
}

#[test]
#[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
fn steps_are_timed_where_the_device_can() {
    let noise = Noise::new(NoiseKind::Stbn, 0);
    let source = MaskSource { fovea: &Fovea::default(), noise: &noise, frame: 0 };
    let mut buffers = SAMPLED.renderer.frame_buffers(FrameSize::new(64, 64).unwrap()).unwrap();
    SAMPLED.renderer.render(&mut buffers, &cameras()[0], Sampling::Compact(source)).unwrap();
    let times = buffers.read_times().unwrap();
    assert_eq!(times.is_some(), GPU.device().features().contains(wgpu::Features::TIMESTAMP_QUERY));
    if let Some(times) = times {
        let stages: Vec<Stage> = times.iter().map(|time| time.stage).collect();
        assert_eq!(stages, [Stage::Mask, Stage::Compact, Stage::March, Stage::Scatter]);
        assert!(times.iter().all(|time| time.ms >= 0.0));
    }
}
