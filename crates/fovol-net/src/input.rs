use fovol_core::SparseFrame;

/// Input of a network for one frame.
#[derive(Debug, Clone, Copy)]
pub struct FrameInput<'a> {
    /// Sampled pixels.
    pub sparse: &'a SparseFrame,
    /// Motion: for each pixel the way to its position in the last frame, x right, y down, in pixels. Networks that
    /// do not use motion ignore it; for others `None` means no motion.
    pub motion: Option<&'a [[f32; 2]]>,
}
