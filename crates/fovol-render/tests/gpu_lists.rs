//! Adaptive masks, and lists with other shadows, on the GPU against the specification.
//!
//! These tests need an adapter, as those of `gpu_twins.rs`.
#![cfg(feature = "gpu")]

use fovol_core::{
    CameraPath, Fovea, FrameSize, Grid, Pixel, Region, SampleList, SampleMask, Scene, ShadowMode,
    TransferFunction, Volume,
};
use fovol_gpu::{AdapterRequest, Gpu, read};
use fovol_render::Importance;
use fovol_render::cpu::{self, RenderOptions, Simd};
use fovol_render::gpu::{DeviceImportance, MaskSource, Renderer, Sampling};
use fovol_render::noise::{Noise, NoiseKind};
use fovol_render::scene::RayResult;
use std::sync::{Arc, LazyLock};
use wgpu::BufferUsages;

static GPU: LazyLock<Gpu> = LazyLock::new(|| Gpu::open(&AdapterRequest::Any.or_environment()).unwrap());

/// Its width is no multiple of a word of a mask.
const SIZE: FrameSize = FrameSize { width: 331, height: 187 };

fn scene() -> Scene {
    let grid = Grid::new([24, 20, 28], [1.0, 1.1, 0.9]).unwrap();
    let value = |i: u64| (i.wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 56) as u8;
    let volume = Volume::from_values(grid, (0..grid.voxels() as u64).map(value).collect()).unwrap();
    Scene::new(Arc::new(volume), TransferFunction::grey_ramp(0.3))
}

fn storage(bytes: &[u8]) -> wgpu::Buffer {
    let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST;
    let buffer = GPU.buffer("importance", bytes.len() as u64, usage);
    GPU.queue().write_buffer(&buffer, 0, bytes);
    buffer
}

/// Cells of `importance` over `region`, row by row.
fn cells(importance: &Importance, region: Region) -> wgpu::Buffer {
    let [columns, rows] = Importance::cells_of(region).map(|cells| cells as u32);
    let at = |i: u32| {
        let [x, y] = [i % columns, i / columns].map(|cell| cell * Importance::CELL as u32);
        importance.at(region.x + x, region.y + y)
    };
    let values: Vec<f32> = (0..columns * rows).map(at).collect();
    storage(bytemuck::cast_slice(&values))
}

fn differing(a: &SampleMask, b: &SampleMask) -> usize {
    let words = a.words().iter().zip(b.words());
    words.map(|(a, b)| (a ^ b).count_ones() as usize).sum()
}

#[test]
#[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
fn adaptive_masks_are_those_of_the_specification() {
    let renderer = Renderer::new(&GPU, &scene()).unwrap();
    let mut buffers = renderer.frame_buffers(SIZE).unwrap();
    let camera = CameraPath::Orbit.camera(0);
    let part = |x, y, width, height| Region { x, y, size: FrameSize { width, height } };
    let parts = [
        [part(0, 0, 331, 187); 2],
        [part(37, 20, 201, 100), part(30, 30, 210, 80)],
        [part(3, 180, 5, 7), part(0, 178, 9, 9)],
    ];
    for [cells_of, region] in parts {
        let [columns, rows] = Importance::cells_of(cells_of);
        // Numbers of several powers of ten, and none.
        let number =
            |i: usize| if i.is_multiple_of(7) { 0.0 } else { 10f32.powi((i % columns) as i32 % 5 - 2) };
        let importance = Importance::new(cells_of, (0..columns * rows).map(number).collect());
        let on_device = cells(&importance, cells_of);
        for (base, sigma) in [(0.03, 0.02), (0.1, 0.3), (0.0, 0.05), (0.0, 0.0), (1.0, 0.0)] {
            let fovea = Fovea { base, sigma, gaze: [0.4, 0.6] };
            for kind in NoiseKind::ALL {
                let noise = Noise::new(kind, 3);
                for frame in [0, 77] {
                    let name = format!("{region:?} {base} {sigma} {kind} {frame}");
                    let source = MaskSource { fovea: &fovea, noise: &noise, frame };
                    let adaptive = DeviceImportance { cells: &on_device, cells_of, region };
                    renderer.render(&mut buffers, &camera, Sampling::Adaptive(source, adaptive)).unwrap();
                    let expected = cpu::adaptive_mask(&fovea, SIZE, &noise, frame, (&importance, region));
                    let found = buffers.read_mask().unwrap();
                    // A key may fall on either side of the limit.
                    let most = 1 + expected.count() / 200;
                    assert!(differing(&expected, &found) <= most, "{name}: {}", differing(&expected, &found));
                    assert_eq!(buffers.read_list().unwrap(), cpu::compact(&found), "{name}");
                }
            }
        }
    }
}

#[test]
#[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
fn lists_with_other_shadows_are_those_of_the_specification() {
    let mut scene = scene();
    scene.shading.shadows = ShadowMode::Cached;
    let mut renderer = Renderer::new(&GPU, &scene).unwrap();
    renderer.keep_cached_shadows().unwrap();
    // They stay where the scene goes over to shadow rays.
    scene.shading.shadows = ShadowMode::On;
    renderer.set_scene(&scene).unwrap();
    let options = RenderOptions { simd: Simd::Scalar, skip_empty: false };
    let mut specification = cpu::Renderer::new(&scene, options).unwrap();
    let mut buffers = renderer.frame_buffers(SIZE).unwrap();
    let pixels: Vec<Pixel> =
        (0..187).step_by(3).flat_map(|y| (0..331).step_by(5).map(move |x| Pixel { x, y })).collect();
    let most = pixels.len() + 100;
    let list = renderer.guide_list(&buffers, most).unwrap();
    let packed: Vec<u32> = pixels.iter().map(|p| u32::from(p.y) << 16 | u32::from(p.x)).collect();
    GPU.queue().write_buffer(list.listed().pixels(), 0, bytemuck::cast_slice(&packed));
    GPU.queue().write_buffer(list.listed().length(), 0, bytemuck::bytes_of(&(packed.len() as u32)));
    let guide_samples = renderer.guide_samples(&buffers).unwrap();
    let samples = SampleList::new(SIZE, pixels[..pixels.len() / 2].to_vec());
    for (i, shadows) in [(0, ShadowMode::Off), (90, ShadowMode::Cached), (200, ShadowMode::Cached)] {
        let camera = CameraPath::Orbit.camera(i);
        GPU.submit("marching a list", |encoder| {
            renderer.encode(encoder, &mut buffers, &camera, Sampling::List(&samples))?;
            renderer.encode_guide_list(encoder, &list, (most as u32, shadows));
            renderer.encode_guide_samples(encoder, (&guide_samples, &buffers), shadows);
            Ok::<_, fovol_render::gpu::Error>(())
        })
        .unwrap();
        let mut expected = |list: &SampleList| match shadows {
            ShadowMode::Off => specification.march_list_without_shadows(&camera, list).0,
            _ => specification.march_list_with_cached_shadows(&camera, list).unwrap().0,
        };
        let all = expected(&SampleList::new(SIZE, pixels.clone()));
        assert_alike(&all, [list.listed().colours(), list.listed().unshadowed()]);
        assert_alike(&expected(&samples), [guide_samples.colours(), guide_samples.guides()]);
    }
}

/// Checks the results on the device: colours with opacities, and inverse depths with guide colours.
fn assert_alike(expected: &[RayResult], [colours, guides]: [&wgpu::Buffer; 2]) {
    let guides: Vec<[f32; 4]> = read(&GPU, guides, expected.len()).unwrap();
    let colours: Vec<[f32; 4]> = read(&GPU, colours, expected.len()).unwrap();
    for ((ray, [inverse, r, g, b]), [.., opacity]) in expected.iter().zip(guides).zip(colours) {
        let pairs = ray.unshadowed.into_iter().zip([r, g, b]);
        assert!(pairs.into_iter().all(|(a, b)| (a - b).abs() <= 2.0 / 255.0), "{ray:?} {r} {g} {b}");
        assert!((ray.opacity - opacity).abs() <= 2.0 / 255.0);
        assert!((1.0 / ray.depth - inverse).abs() <= 0.05, "{ray:?} {inverse}");
    }
}
