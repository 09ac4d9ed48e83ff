//! Few shadow rays on a GPU against those on the processor.
//!
//! These tests need an adapter, a software one included: `cargo test --workspace -- --ignored`.
#![cfg(feature = "gpu")]

mod gpu_frames;
mod scenes;

use fovol_core::{FrameSize, Integration, Pixel, SampleList, Scene, SurfaceShading};
use fovol_render::cpu::{self, FewShadowRays, RenderOptions};
use fovol_render::gpu::{Renderer, Sampling};
use fovol_render::noise::{Noise, NoiseKind};
use fovol_render::scene::RayResult;
use gpu_frames::{GPU, full_frame, small_scene};
use scenes::{cameras, differences};

/// Its width is no multiple of the tile of noise.
const SIZE: FrameSize = FrameSize { width: 147, height: 53 };

/// Part of the colours that differ by more than 2/255, and their mean difference. Where rounding moves a shadow ray to the next
/// sample, both colours have the same right to be there.
fn moved(a: &[[f32; 3]], b: &[[f32; 3]]) -> (f64, f64) {
    let pairs = a.iter().zip(b);
    let far = |(a, b): (&[f32; 3], &[f32; 3])| (0..3).map(|c| (a[c] - b[c]).abs()).fold(0.0, f32::max);
    let moved = pairs.clone().filter(|pair| far(*pair) > 2.0 / 255.0).count();
    let sum: f64 = pairs.map(|(a, b)| (0..3).map(|c| f64::from(a[c] - b[c])).sum::<f64>()).sum();
    (moved as f64 / a.len() as f64, sum / (3 * a.len()) as f64)
}

fn assert_alike(found: &[[f32; 3]], expected: &[[f32; 3]], what: &str) {
    let (moved, mean) = moved(found, expected);
    assert!(moved < 0.03 && mean.abs() < 5e-4, "{what}: {moved} of the pixels, {mean} on average");
}

fn colours(rays: &[RayResult]) -> Vec<[f32; 3]> {
    rays.iter().map(|ray| ray.colour).collect()
}

fn check(scene: &Scene, (per_pixel, kind): (u32, NoiseKind)) {
    let what = format!("{per_pixel} {kind} {:?} {:?}", scene.integration, scene.shading.surface);
    let processor = cpu::Renderer::new(scene, RenderOptions::default()).unwrap();
    let renderer = Renderer::new(&GPU, scene).unwrap();
    let mut buffers = renderer.frame_buffers(SIZE).unwrap();
    let noise = Noise::new(kind, 5);
    let pixels = (0..53).flat_map(|y| (0..147).step_by(2).map(move |x| Pixel { x, y })).collect();
    let list = SampleList::new(SIZE, pixels);
    for (frame, camera) in [3, 70].into_iter().zip(cameras()) {
        let few = FewShadowRays { per_pixel, noise: noise.frame(frame) };
        buffers.set_few_shadow_rays(Some(&few));
        renderer.render(&mut buffers, &camera, Sampling::List(&list)).unwrap();
        let found = buffers.read_samples().unwrap();
        let (expected, _) = processor.march_list_with(&camera, &list, Some(&few));
        assert_alike(&colours(&found), &colours(&expected), &what);
        let unshadowed = |rays: &[RayResult]| rays.iter().map(|ray| ray.unshadowed).collect::<Vec<_>>();
        assert_alike(&unshadowed(&found), &unshadowed(&expected), &what);
        let whole = full_frame(&renderer, &mut buffers, &camera);
        let (expected, _) = processor.march_full_with(&camera, SIZE, Some(&few));
        let (.., mean) = differences(&whole, &expected);
        assert!(mean < 1e-3, "{what}: {mean} on average");
        buffers.set_few_shadow_rays(None);
        renderer.render(&mut buffers, &camera, Sampling::List(&list)).unwrap();
        let exact = buffers.read_samples().unwrap();
        let (noisy, _) = moved(&colours(&exact), &colours(&found));
        assert!(per_pixel > 1 || noisy > 0.02, "{what} changes nothing");
    }
}

#[test]
#[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
fn few_shadow_rays_begin_where_those_of_the_processor_do() {
    let mut scene = small_scene();
    for integration in [Integration::Plain, Integration::Fine] {
        for surface in [SurfaceShading::Flat, SurfaceShading::Gradient] {
            (scene.integration, scene.shading.surface) = (integration, surface);
            for few in [(1, NoiseKind::Stbn), (4, NoiseKind::Uniform), (16, NoiseKind::Stbn)] {
                check(&scene, few);
            }
        }
    }
}
