//! The shaders: files of `src/shaders`.

use fovol_gpu::{Shader, shader};

/// Decides which pixels are sampled.
pub const MASK: Shader = shader!("../shaders/", "mask": "frame" "random" "ranks");
/// Decides which pixels are sampled where densities follow importance.
pub const ADAPTIVE_MASK: Shader =
    shader!("../shaders/", "adaptive_mask": "frame" "random" "ranks" "inclusive_sum");
/// Packs the sampled pixels into a list.
pub const COMPACT: Shader = shader!("../shaders/", "compact": "frame" "inclusive_sum");
/// Marches rays; the shader interpolates voxels.
pub const MARCH: Shader = shader!("../shaders/", "march": "frame" "random" "scene" "field" "medium" "skip" "segment" "light_columns" "shadow_rays" "shadow_lookup" "few_shadow_rays" "ray" "modes" "fine" "fine_march");
/// Marches rays; texture samplers interpolate voxels.
pub const MARCH_FILTERED: Shader = shader!("../shaders/", "march": "frame" "random" "scene" "field_filtered" "medium" "skip" "segment" "light_columns" "shadow_rays" "shadow_lookup" "few_shadow_rays" "ray" "modes" "fine" "fine_march");
/// Marches rays through several volumes, or voxels with colours.
pub const MARCH_LAYERED: Shader = shader!("../shaders/", "march": "frame" "random" "scene" "field" "layers" "skip" "segment" "light_columns" "shadow_rays" "shadow_lookup" "few_shadow_rays" "ray" "modes" "fine" "fine_march");
/// Marches rays by workgroups; the shader interpolates voxels.
pub const POOL: Shader = shader!("../shaders/", "pool": "frame" "scene" "field" "medium" "skip" "segment" "light_columns" "shadow_rays" "shadow_lookup" "ray" "pool_rays" "pool_plain");
/// Marches rays by workgroups; texture samplers interpolate voxels.
pub const POOL_FILTERED: Shader = shader!("../shaders/", "pool": "frame" "scene" "field_filtered" "medium" "skip" "segment" "light_columns" "shadow_rays" "shadow_lookup" "ray" "pool_rays" "pool_plain");
/// Marches rays by workgroups with fine integration; the shader interpolates voxels.
pub const POOL_FINE: Shader = shader!("../shaders/", "pool": "frame" "scene" "field" "medium" "skip" "segment" "light_columns" "shadow_rays" "shadow_lookup" "ray" "fine" "pool_rays" "pool_fine");
/// Marches rays by workgroups with fine integration; texture samplers interpolate voxels.
pub const POOL_FINE_FILTERED: Shader = shader!("../shaders/", "pool": "frame" "scene" "field_filtered" "medium" "skip" "segment" "light_columns" "shadow_rays" "shadow_lookup" "ray" "fine" "pool_rays" "pool_fine");
/// Scatters packed samples into a sparse frame.
pub const SCATTER: Shader = shader!("../shaders/", "scatter": "frame");
/// Fills the shadow grid with transmittance; the shader interpolates voxels.
pub const SHADOW_GRID: Shader =
    shader!("../shaders/", "shadow_grid": "scene" "field" "medium" "skip" "light_columns" "shadow_rays");
/// Fills the shadow grid with transmittance; texture samplers interpolate voxels.
pub const SHADOW_GRID_FILTERED: Shader = shader!("../shaders/", "shadow_grid": "scene" "field_filtered" "medium" "skip" "light_columns" "shadow_rays");
/// Fills the shadow grid with transmittance through several volumes, or voxels with colours.
pub const SHADOW_GRID_LAYERED: Shader =
    shader!("../shaders/", "shadow_grid": "scene" "field" "layers" "skip" "light_columns" "shadow_rays");

#[cfg(test)]
mod tests {
    use super::*;
    use wgpu::naga::valid::Capabilities;

    const ALL: [Shader; 14] = [
        MASK,
        ADAPTIVE_MASK,
        COMPACT,
        MARCH,
        MARCH_FILTERED,
        MARCH_LAYERED,
        POOL,
        POOL_FILTERED,
        POOL_FINE,
        POOL_FINE_FILTERED,
        SCATTER,
        SHADOW_GRID,
        SHADOW_GRID_FILTERED,
        SHADOW_GRID_LAYERED,
    ];

    #[test]
    fn every_shader_is_valid_without_any_optional_feature() {
        for shader in ALL {
            shader.check(Capabilities::empty()).unwrap_or_else(|problem| panic!("{problem}"));
        }
    }

    #[test]
    fn no_shader_is_left_out() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/src/shaders");
        let all: String = ALL.map(|shader| shader.source()).concat();
        for file in std::fs::read_dir(folder).unwrap() {
            let path = file.unwrap().path();
            assert!(all.contains(&std::fs::read_to_string(&path).unwrap()), "{} is not used", path.display());
        }
    }
}
