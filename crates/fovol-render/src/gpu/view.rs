use crate::noise::FrameNoise;
use crate::scene::Segments;
use bytemuck::{Pod, Zeroable};
use fovol_core::{Projection, RayBasis};

/// The camera and the noise of few shadow rays, as shaders read them. Twin of `View` in shaders/segment.wgsl.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct View {
    eye: [f32; 4],
    forward: [f32; 3],
    parallel: u32,
    right: [f32; 4],
    up: [f32; 4],
    noise_seed: [u32; 2],
    noise_hashed: u32,
    noise_levels: f32,
}

impl View {
    /// The camera of `rays` in the grid of `segments`. The eye is converted in f64, as f32 would round large numbers.
    pub fn new(rays: &RayBasis, segments: &Segments, noise: NoiseNumbers) -> Self {
        let padded = |[x, y, z]: [f32; 3]| [x, y, z, 0.0];
        let is_parallel = rays.projection() == Projection::Orthographic;
        let [forward, right, up] = rays.axes().map(|axis| axis.as_vec3().to_array());
        let NoiseNumbers { seed, hashed, levels } = noise;
        Self {
            eye: padded(segments.in_voxels(rays.origin())),
            forward,
            parallel: u32::from(is_parallel),
            right: padded(right),
            up: padded(up),
            noise_seed: seed,
            noise_hashed: hashed,
            noise_levels: levels,
        }
    }
}

/// Numbers of the noise of few shadow rays, besides its tile.
#[derive(Debug, Clone, Copy)]
pub struct NoiseNumbers {
    seed: [u32; 2],
    hashed: u32,
    levels: f32,
}

impl NoiseNumbers {
    /// Numbers of frames without few shadow rays.
    pub const NONE: Self = Self { seed: [0; 2], hashed: 0, levels: 1.0 };

    pub fn new(noise: &FrameNoise<'_>) -> Self {
        let seed = noise.seed();
        let words = seed.map_or([0; 2], |seed| [seed as u32, (seed >> 32) as u32]);
        Self { seed: words, hashed: u32::from(seed.is_some()), levels: noise.levels() as f32 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::shader::MARCH;
    use fovol_gpu::assert_twins;

    #[test]
    fn shaders_read_the_same_struct() {
        assert_twins!(
            MARCH,
            "View",
            View { eye, forward, parallel, right, up, noise_seed, noise_hashed, noise_levels }
        );
    }
}
