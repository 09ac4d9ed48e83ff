use super::timings::Timings;
use crate::guide::UpsampledGuide;
use fovol_core::{Frame, SampleMask, SparseFrame};

/// Rendered frame and its intermediate results.
#[derive(Debug, Clone)]
pub struct RenderedFrame {
    /// Frame number.
    pub index: u32,
    /// Marched pixels; `None` if every pixel was marched, so that `frame` holds them.
    pub sparse: Option<SparseFrame>,
    /// Sampled pixels.
    pub mask: SampleMask,
    /// Full frame; a picture of the samples if reconstruction is off.
    pub frame: Frame,
    /// Motion of each pixel to its position in the last frame, see [`crate::MotionFinder`]. Present from the second
    /// frame on, if a network uses motion or [`crate::Pipeline::find_motion`] was called.
    pub motion: Option<Vec<[f32; 2]>>,
    /// Number of marched pixels, repeated ones included.
    pub samples: usize,
    /// Number of pixels that were marched without shadow rays, for the guide.
    pub guide_samples: usize,
    /// Guide and light ratio, if there are any and [`crate::Pipeline::keep_guide`] was called.
    pub guide: Option<FrameGuide>,
    /// Number of repeated pixels, if positions were drawn at random.
    pub lost: Option<usize>,
    /// Times of the stages.
    pub timings: Timings,
}

/// Guide of a frame and the light ratio that was reconstructed with it.
#[derive(Debug, Clone)]
pub struct FrameGuide {
    /// Guide at every pixel.
    pub guide: UpsampledGuide,
    /// Light ratio at every pixel: red, green and blue, 0…1.
    pub ratio: Frame,
}

impl RenderedFrame {
    /// Picture of the marched pixels: alpha 1 there, transparent black elsewhere.
    pub fn samples_picture(&self) -> Frame {
        self.sparse.as_ref().map_or_else(|| self.frame.clone(), SparseFrame::to_frame)
    }

    /// Colours of the marched pixels.
    pub fn sample_colours(&self) -> impl Iterator<Item = [f32; 3]> {
        let listed = self.sparse.iter().flat_map(|sparse| sparse.colours().iter().copied());
        let every = if self.sparse.is_none() { self.frame.pixels() } else { &[] };
        listed.chain(every.iter().map(|&[r, g, b, _]| [r, g, b]))
    }
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
