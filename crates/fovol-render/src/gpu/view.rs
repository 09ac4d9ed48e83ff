use crate::scene::Segments;
use bytemuck::{Pod, Zeroable};
use fovol_core::RayBasis;

/// The camera, as shaders read it. Twin of `View` in shaders/segment.wgsl.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct View {
    eye: [f32; 4],
    forward: [f32; 4],
    right: [f32; 4],
    up: [f32; 4],
}

impl View {
    /// The camera of `rays` in the grid of `segments`. The eye is converted in f64, as f32 would round large numbers.
    pub fn new(rays: &RayBasis, segments: &Segments) -> Self {
        let padded = |[x, y, z]: [f32; 3]| [x, y, z, 0.0];
        let [forward, right, up] = rays.axes().map(|axis| padded(axis.as_vec3().to_array()));
        Self { eye: padded(segments.in_voxels(rays.origin())), forward, right, up }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::shader::MARCH;
    use fovol_gpu::assert_twins;

    #[test]
    fn shaders_read_the_same_struct() {
        assert_twins!(MARCH, "View", View { eye, forward, right, up });
    }
}
