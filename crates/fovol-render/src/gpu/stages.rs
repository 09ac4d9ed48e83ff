use super::adaptive_mask::AdaptiveMaskPass;
use super::buffers::{Buffers, Groups};
use super::compact::CompactPass;
use super::layers::Layering;
use super::march::MarchPass;
use super::mask::MaskPass;
use super::scatter::ScatterPass;
use super::shadow_grid::ShadowGridPass;
use super::volume_texture::TexelKind;
use fovol_gpu::Gpu;

/// The pipelines of all steps.
#[derive(Debug)]
pub struct Stages {
    pub mask: MaskPass,
    pub adaptive_mask: AdaptiveMaskPass,
    pub compact: CompactPass,
    pub march: MarchPass,
    pub scatter: ScatterPass,
    pub shadow_grid: ShadowGridPass,
}

impl Stages {
    /// Makes the pipelines for volumes of these texels and layers.
    pub fn new(gpu: &Gpu, texels: TexelKind, layers: Layering) -> Self {
        Self {
            mask: MaskPass::new(gpu),
            adaptive_mask: AdaptiveMaskPass::new(gpu),
            compact: CompactPass::new(gpu),
            march: MarchPass::new(gpu, texels, layers),
            scatter: ScatterPass::new(gpu),
            shadow_grid: ShadowGridPass::new(gpu, texels, layers),
        }
    }

    /// Binds `buffers` for each step.
    pub fn bind(&self, gpu: &Gpu, buffers: &Buffers) -> Groups {
        Groups {
            mask: self.mask.bind(gpu, buffers),
            compact: self.compact.bind(gpu, buffers),
            march_list: self.march.bind(gpu, buffers, &buffers.listed, &buffers.listed.results),
            march_frame: self.march.bind(gpu, buffers, &buffers.listed, &buffers.frame),
            scatter: self.scatter.bind(gpu, buffers),
        }
    }
}
