//! Reprojections as shaders read them.

use bytemuck::{Pod, Zeroable};
use fovol_core::{Camera, FrameSize, Projection, Reprojection};
use fovol_gpu::Gpu;
use wgpu::BufferUsages;

/// Uniforms of a reprojection. Twin of `Reprojection` in shaders/reprojection.wgsl.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct ReprojectionUniforms {
    base: [[f32; 4]; 3],
    direction: [[f32; 4]; 3],
    parallax: [f32; 4],
    width: u32,
    height: u32,
    half_width: f32,
    half_height: f32,
}

impl ReprojectionUniforms {
    /// From pixels of frames of `size` seen by `from` to those seen by `to`.
    pub fn new(from: &Camera, to: &Camera, size: FrameSize) -> Self {
        let reprojection = Reprojection::new(from, to, size);
        let parallel = f32::from(reprojection.projection() == Projection::Orthographic);
        let [a, b, c, d, e, f, parallax] = reprojection.coefficients().map(|v| [v.x, v.y, v.z, parallel]);
        let [half_width, half_height] = reprojection.half_extent();
        Self {
            base: [a, b, c],
            direction: [d, e, f],
            parallax,
            width: size.width,
            height: size.height,
            half_width,
            half_height,
        }
    }

    /// Uniform buffer of `count` reprojections.
    pub fn buffer(gpu: &Gpu, count: usize) -> wgpu::Buffer {
        let usage = BufferUsages::UNIFORM | BufferUsages::COPY_DST;
        gpu.buffer("reprojection", (count * size_of::<Self>()) as u64, usage)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovol_gpu::{Shader, assert_twins, shader};

    /// One of the shaders that read reprojections.
    const READER: Shader = shader!("../../shaders/", "motion": "reprojection");

    #[test]
    fn shaders_read_the_same_struct() {
        assert_twins!(
            READER,
            "Reprojection",
            ReprojectionUniforms { base, direction, parallax, width, height, half_width, half_height }
        );
    }
}
