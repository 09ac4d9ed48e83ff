use super::list_buffers::ListBuffers;

/// A list of pixels that are marched without shadows. Whoever makes it on the device puts pixels and length into its buffers.
///
/// Made by [`super::Renderer::unshadowed_list`] for the frames of one [`super::FrameBuffers`].
#[derive(Debug)]
pub struct UnshadowedList {
    pub(super) listed: ListBuffers,
    pub(super) group: wgpu::BindGroup,
}

impl UnshadowedList {
    /// The pixels and the results of their rays.
    pub fn listed(&self) -> &ListBuffers {
        &self.listed
    }
}
