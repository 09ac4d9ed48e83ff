//! Shaders, from the folder `src/shaders`.

use fovol_gpu::{Shader, shader};

/// Inputs and output of a network.
pub const FRAME: Shader = shader!("../../shaders/", "frame": "tensor");
/// Clean-up of states.
pub const KEEP: Shader = shader!("../../shaders/", "keep": "tensor");
/// Convolutions on any device.
pub const CONV: Shader = shader!("../../shaders/", "conv": "tensor" "doubled" "convolution");
/// Convolutions with cooperative matrices of 8 × 8.
pub const CONV_MATRICES_8: Shader =
    shader!("../../shaders/", "conv_matrices": "matrices_8" "tensor" "doubled" "convolution");
/// Convolutions with cooperative matrices of 16 × 16.
pub const CONV_MATRICES_16: Shader =
    shader!("../../shaders/", "conv_matrices": "matrices_16" "tensor" "doubled" "convolution");
/// Predicted kernels.
pub const FILTER: Shader = shader!("../../shaders/", "filter": "tensor" "doubled");
/// Normalisation over the frame.
pub const NORM: Shader = shader!("../../shaders/", "norm": "tensor");
/// Averages of 2×2 pixels.
pub const POOL: Shader = shader!("../../shaders/", "pool": "tensor");
/// Layers that reorder elements.
pub const RESHAPE: Shader = shader!("../../shaders/", "reshape": "tensor");
/// Pointwise layers.
pub const POINTWISE: Shader = shader!("../../shaders/", "pointwise": "tensor");
/// Pull-push pyramid inside a network.
pub const PYRAMID: Shader = shader!("../../shaders/", "pyramid": "tensor" "doubled" "pulled");
/// The coarsest levels of this pyramid.
pub const PYRAMID_TOP: Shader = shader!("../../shaders/", "pyramid_top": "tensor" "doubled" "pulled");
/// Smoothing, and filling from spread pictures.
pub const SPREAD: Shader = shader!("../../shaders/", "spread": "tensor" "doubled");
/// Accumulation of earlier samples.
pub const ACCUMULATE: Shader = shader!("../../shaders/", "accumulate": "tensor" "reprojected");
/// Reprojection of images.
pub const WARP: Shader = shader!("../../shaders/", "warp": "tensor");
/// Reprojection and resampling of points.
pub const POINTS: Shader = shader!("../../shaders/", "points": "tensor" "reprojected");
/// Pull-push without a network.
pub const PULL_PUSH: Shader = shader!("../../shaders/", "pull_push":);

#[cfg(test)]
mod tests {
    use super::*;
    use wgpu::naga::valid::Capabilities;

    /// Shaders that every device runs.
    const ALL: [Shader; 15] = [
        FRAME,
        KEEP,
        CONV,
        FILTER,
        NORM,
        POOL,
        RESHAPE,
        POINTWISE,
        PYRAMID,
        PYRAMID_TOP,
        SPREAD,
        ACCUMULATE,
        POINTS,
        WARP,
        PULL_PUSH,
    ];
    const MATRICES: [Shader; 2] = [CONV_MATRICES_8, CONV_MATRICES_16];

    #[test]
    fn every_shader_is_valid_without_any_optional_feature() {
        // Every WebGPU has this capability; naga lists it separately because of WebGL.
        for shader in ALL {
            shader
                .check(Capabilities::SHADER_FLOAT16_IN_FLOAT32)
                .unwrap_or_else(|problem| panic!("{problem}"));
        }
    }

    #[test]
    fn shaders_of_matrices_are_valid_where_there_are_matrices() {
        let needed = Capabilities::SHADER_FLOAT16
            | Capabilities::SHADER_FLOAT16_IN_FLOAT32
            | Capabilities::SUBGROUP
            | Capabilities::COOPERATIVE_MATRIX;
        for shader in MATRICES {
            shader.check(needed).unwrap_or_else(|problem| panic!("{problem}"));
            assert!(shader.check(needed - Capabilities::COOPERATIVE_MATRIX).is_err());
        }
    }

    #[test]
    fn no_shader_is_left_out() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/src/shaders");
        let all: String = ALL.iter().chain(&MATRICES).map(Shader::source).collect();
        for file in std::fs::read_dir(folder).unwrap() {
            let path = file.unwrap().path();
            assert!(all.contains(&std::fs::read_to_string(&path).unwrap()), "{} is not used", path.display());
        }
    }
}
