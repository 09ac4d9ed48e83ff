use fovol_core::Frame;

/// Input of a network for one frame.
#[derive(Debug, Clone, Copy)]
pub struct FrameInput<'a> {
    /// Sparse frame: alpha 1 where sampled.
    pub sparse: &'a Frame,
    /// Motion: for each pixel the way to its position in the last frame, x right, y down, in pixels. Networks that
    /// do not use motion ignore it; for others `None` means no motion.
    pub motion: Option<&'a [[f32; 2]]>,
}
