use super::depths::Depths;
use fovol_core::Frame;

/// Sparse frame with depths, before reconstruction.
#[derive(Debug, Clone, Copy)]
pub struct Sparse<'a> {
    /// Sampled colours; alpha is 1 at samples.
    pub frame: &'a Frame,
    /// Depths of the samples.
    pub depths: &'a Depths,
}
