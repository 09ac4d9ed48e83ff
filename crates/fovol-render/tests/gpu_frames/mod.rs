//! An adapter, a small scene, and frames of it.

use crate::scenes::{transfer, volumes};
use fovol_core::{Camera, Frame, Scene};
use fovol_gpu::{AdapterRequest, Gpu};
use fovol_render::gpu::{FrameBuffers, Renderer, Sampling};
use std::sync::{Arc, LazyLock};

/// The adapter of the tests, a software one included.
pub static GPU: LazyLock<Gpu> = LazyLock::new(|| Gpu::open(&AdapterRequest::Any.or_environment()).unwrap());

/// A scene that is quickly rendered.
pub fn small_scene() -> Scene {
    let (_, volume) = volumes().remove(0);
    let mut scene = Scene::new(Arc::new(volume), transfer());
    scene.background = [0.1, 0.2, 0.3];
    scene
}

/// Every pixel of `renderer`'s scene.
pub fn full_frame(renderer: &Renderer, buffers: &mut FrameBuffers, camera: &Camera) -> Frame {
    renderer.render(buffers, camera, Sampling::Full).unwrap();
    buffers.read_frame().unwrap()
}
