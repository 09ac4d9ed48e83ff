//! Estimate of a pipeline's memory, checked before any is allocated.

use super::Pipeline;
use crate::{Error, OpenDevice, RenderSettings, Result, Sampling};
use fovol_core::memory::{Estimate, SMALLER_BOTH, SMALLER_FRAMES};
use fovol_core::{Pixel, Scene};
use fovol_render::cpu::Renderer;
use fovol_render::scene::RayResult;

/// Bytes of one pixel of a frame.
const COLOUR: usize = size_of::<[f32; 4]>();
/// Bytes of one marched pixel and its ray result.
const MARCHED: usize = size_of::<Pixel>() + size_of::<RayResult>();

/// Returns an error if the pipeline would not fit into memory.
pub fn check(device: &OpenDevice, scene: &Scene, settings: &RenderSettings) -> Result<()> {
    let size = settings.frame_size();
    let estimate = Renderer::estimate(scene, Estimate::new(format!("rendering frames of {size}")));
    let estimate = match device {
        OpenDevice::Cpu => estimate.with("frames", frames(settings)),
        // On a GPU the host memory holds only uploads and read-backs.
        #[cfg(feature = "gpu")]
        OpenDevice::Gpu(_) => estimate,
    };
    Ok(estimate.check(SMALLER_BOTH).map_err(fovol_core::Error::from)?)
}

/// Bytes of the frames that exist at the same time while one is rendered.
fn frames(settings: &RenderSettings) -> u64 {
    let bytes = match settings.sampling() {
        // All ray results, and the frame made from them.
        Sampling::Full => COLOUR + MARCHED,
        // The sparse frame and the full one.
        Sampling::Reject | Sampling::Direct | Sampling::Compact => 2 * COLOUR,
    };
    (settings.frame_size().pixels() * bytes) as u64
}

impl Pipeline {
    /// Checks that frames and their references fit into memory together.
    ///
    /// # Errors
    /// Too little memory.
    pub fn check_references(&self) -> Result<()> {
        let size = self.size();
        let pixels = size.pixels();
        // The sparse and the full frame are kept while the reference is rendered.
        Estimate::new(format!("rendering frames of {size} and their references"))
            .with("frames", (pixels * 2 * COLOUR) as u64)
            .with("references", (pixels * (COLOUR + MARCHED)) as u64)
            .check(SMALLER_FRAMES)
            .map_err(|shortage| Error::Core(shortage.into()))
    }
}
