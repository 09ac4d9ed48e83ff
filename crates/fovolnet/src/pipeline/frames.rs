use super::timings::Timings;
use fovol_core::{Frame, SampleMask};

/// Rendered frame and its intermediate results.
#[derive(Debug, Clone)]
pub struct RenderedFrame {
    /// Frame number.
    pub index: u32,
    /// Sparse frame: alpha 1 at samples, transparent black elsewhere.
    pub sparse: Frame,
    /// Sampled pixels.
    pub mask: SampleMask,
    /// Full frame; the sparse one if reconstruction is off.
    pub frame: Frame,
    /// Motion of each pixel to its position in the last frame, see [`crate::MotionFinder`]. Present from the second
    /// frame on, if a network uses motion or [`crate::Pipeline::find_motion`] was called.
    pub motion: Option<Vec<[f32; 2]>>,
    /// Number of marched pixels, repeated ones included.
    pub samples: usize,
    /// Number of repeated pixels, if positions were drawn at random.
    pub lost: Option<usize>,
    /// Times of the stages.
    pub timings: Timings,
}

/// Facts about a finished frame that stayed on the device.
#[cfg(feature = "gpu")]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DoneFrame {
    /// Frame number.
    pub index: u32,
    /// Number of marched pixels, repeated ones included.
    pub samples: usize,
    /// Times on the device.
    pub timings: Timings,
}

/// Frame that stays on the device, see [`crate::Pipeline::display_from`].
#[cfg(feature = "gpu")]
#[derive(Debug, Clone)]
pub struct DeviceFrame {
    /// Frame number.
    pub index: u32,
    /// Full frame: opaque display colours in rgba8unorm. Later submissions to the queue see it finished. The third
    /// frame after this one overwrites it.
    pub picture: wgpu::Texture,
    /// Facts about the frame two before this one, which is finished. `None` for the first two frames after a fresh
    /// start.
    pub done: Option<DoneFrame>,
}
