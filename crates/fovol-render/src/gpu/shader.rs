//! The shaders: files of `src/shaders`.

use fovol_gpu::{Shader, shader};

/// Which pixels are sampled.
pub const MASK: Shader = shader!("../shaders/", "mask": "frame" "random");
/// The sampled pixels as a list.
pub const COMPACT: Shader = shader!("../shaders/", "compact": "frame");
/// Image formation.
pub const MARCH: Shader =
    shader!("../shaders/", "march": "frame" "scene" "field" "skip" "segment" "shadow_rays");
/// From packed samples to a sparse frame.
pub const SCATTER: Shader = shader!("../shaders/", "scatter": "frame");
/// Transmittance towards the light at half resolution.
pub const SHADOW_GRID: Shader = shader!("../shaders/", "shadow_grid": "scene" "field" "skip" "shadow_rays");

#[cfg(test)]
mod tests {
    use super::*;
    use wgpu::naga::valid::Capabilities;

    #[test]
    fn every_shader_is_valid_without_any_optional_feature() {
        for shader in [MASK, COMPACT, MARCH, SCATTER, SHADOW_GRID] {
            shader.check(Capabilities::empty()).unwrap_or_else(|problem| panic!("{problem}"));
        }
    }

    #[test]
    fn no_shader_is_left_out() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/src/shaders");
        let all: String = [MASK, COMPACT, MARCH, SCATTER, SHADOW_GRID].map(|shader| shader.source()).concat();
        for file in std::fs::read_dir(folder).unwrap() {
            let path = file.unwrap().path();
            assert!(all.contains(&std::fs::read_to_string(&path).unwrap()), "{} is not used", path.display());
        }
    }
}
