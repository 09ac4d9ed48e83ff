use super::list_buffers::{ListBuffers, Shaded};

/// A list of pixels that are marched with other shadows than the scene has. Whoever makes it on the device puts pixels and length
/// into its buffers.
///
/// Made by [`super::Renderer::guide_list`] for the frames of one [`super::FrameBuffers`].
#[derive(Debug)]
pub struct GuideList {
    pub(super) listed: ListBuffers,
    pub(super) group: wgpu::BindGroup,
}

impl GuideList {
    /// The pixels and the results of their rays.
    pub fn listed(&self) -> &ListBuffers {
        &self.listed
    }
}

/// Results of the samples of a frame, marched once more with other shadows.
///
/// Made by [`super::Renderer::guide_samples`] for the frames of one [`super::FrameBuffers`].
#[derive(Debug)]
pub struct GuideSamples {
    pub(super) results: Shaded,
    pub(super) group: wgpu::BindGroup,
}

impl GuideSamples {
    /// For each sample red, green and blue over the background, and opacity; f32.
    pub fn colours(&self) -> &wgpu::Buffer {
        &self.results.colours
    }

    /// For each sample the inverse depth, and red, green and blue with the other shadows before the background; f32.
    pub fn guides(&self) -> &wgpu::Buffer {
        &self.results.inverse_depths
    }
}
