//! The shaders: files of `src/shaders`.

use fovol_gpu::{Shader, shader};

/// Inputs and outputs.
pub const FRAME: Shader = shader!("../shaders/", "frame": "tensor");
/// What goes from frame to frame.
pub const KEEP: Shader = shader!("../shaders/", "keep": "tensor");
/// Convolutions on any device.
pub const CONV: Shader = shader!("../shaders/", "conv": "tensor" "doubled" "convolution");
/// Convolutions by cooperative matrices of 8 rows and columns.
pub const CONV_MATRICES_8: Shader =
    shader!("../shaders/", "conv_matrices": "matrices_8" "tensor" "doubled" "convolution");
/// Convolutions by cooperative matrices of 16 rows and columns.
pub const CONV_MATRICES_16: Shader =
    shader!("../shaders/", "conv_matrices": "matrices_16" "tensor" "doubled" "convolution");
/// Predicted kernels.
pub const FILTER: Shader = shader!("../shaders/", "filter": "tensor" "doubled");
/// Normalisation over the frame.
pub const NORM: Shader = shader!("../shaders/", "norm": "tensor");
/// Means of 2×2 pixels.
pub const POOL: Shader = shader!("../shaders/", "pool": "tensor");
/// Layers that move numbers.
pub const RESHAPE: Shader = shader!("../shaders/", "reshape": "tensor");
/// Layers that change numbers one by one.
pub const POINTWISE: Shader = shader!("../shaders/", "pointwise": "tensor");
/// Known pixels averaged over larger squares.
pub const PYRAMID: Shader = shader!("../shaders/", "pyramid": "tensor" "doubled");
/// What is done with pictures that were spread.
pub const SPREAD: Shader = shader!("../shaders/", "spread": "tensor" "doubled");
/// What is left of earlier samples.
pub const ACCUMULATE: Shader = shader!("../shaders/", "accumulate": "tensor");
/// Where pixels were.
pub const WARP: Shader = shader!("../shaders/", "warp": "tensor");
/// Samples of earlier frames as points.
pub const POINTS: Shader = shader!("../shaders/", "points": "tensor");
/// Filling without a network.
pub const PULL_PUSH: Shader = shader!("../shaders/", "pull_push":);

#[cfg(test)]
mod tests {
    use super::*;
    use wgpu::naga::valid::Capabilities;

    /// Those that every device runs.
    const ALL: [Shader; 14] = [
        FRAME, KEEP, CONV, FILTER, NORM, POOL, RESHAPE, POINTWISE, PYRAMID, SPREAD, ACCUMULATE, POINTS, WARP,
        PULL_PUSH,
    ];
    const MATRICES: [Shader; 2] = [CONV_MATRICES_8, CONV_MATRICES_16];

    #[test]
    fn every_shader_is_valid_without_any_optional_feature() {
        // What every WebGPU has, and naga lists apart for the sake of WebGL.
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
