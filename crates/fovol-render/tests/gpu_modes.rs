//! Projections, isosurfaces, parallel rays and clip planes on the GPU, against the specification.
//!
//! These tests need an adapter, as gpu_twins.rs says.
#![cfg(feature = "gpu")]

mod gaps;
mod gpu_frames;
mod scenes;
mod varied;

use fovol_core::FrameSize;
use fovol_render::cpu::{self, RenderOptions, Simd};
use fovol_render::gpu::Renderer;
use gpu_frames::{GPU, full_frame, small_scene};
use scenes::differences;

#[test]
#[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
fn pictures_are_those_of_the_specification() {
    let size = FrameSize::new(93, 61).unwrap();
    varied::scenes(|name, scene, cameras| {
        let scalar = RenderOptions { simd: Simd::Scalar, skip_empty: false };
        let cpu = cpu::Renderer::new(scene, scalar).unwrap();
        let mut gpu = Renderer::new(&GPU, scene).unwrap();
        let mut buffers = gpu.frame_buffers(size).unwrap();
        for camera in cameras {
            let (expected, _) = cpu.march_full(camera, size);
            for skip_empty in [false, true] {
                gpu.set_skip_empty(skip_empty);
                let frame = full_frame(&gpu, &mut buffers, camera);
                let (p999, most, mean) = differences(&expected, &frame);
                assert!(
                    p999 <= 2.0 / 255.0 && most <= varied::MOST && mean <= 2e-3,
                    "{name} skip {skip_empty}: {p999} {most} {mean}"
                );
            }
        }
    });
}

/// Every change of the mode, on a device that has its scene already.
#[test]
#[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
fn a_changed_mode_is_as_a_new_one() {
    use fovol_core::RayMode::{Average, Composite, Isosurface, Mip};
    let size = FrameSize::new(48, 32).unwrap();
    let mut scene = small_scene();
    let camera = scenes::cameras()[0];
    let mut changed = Renderer::new(&GPU, &scene).unwrap();
    let mut buffers = changed.frame_buffers(size).unwrap();
    for mode in [Isosurface(0.3), Composite, Average, Isosurface(0.5), Mip, Composite] {
        scene.mode = mode;
        changed.set_scene(&scene).unwrap();
        let found = full_frame(&changed, &mut buffers, &camera);
        let anew = Renderer::new(&GPU, &scene).unwrap();
        let right = full_frame(&anew, &mut anew.frame_buffers(size).unwrap(), &camera);
        assert_eq!(found.pixels(), right.pixels(), "{mode:?}");
    }
}
