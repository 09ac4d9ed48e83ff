//! The memory that a pipeline will take, added up before any of it is asked for.

use super::Pipeline;
use crate::{Error, OpenDevice, RenderSettings, Result, Sampling};
use fovol_core::memory::{Estimate, SMALLER_BOTH, SMALLER_FRAMES};
use fovol_core::{Pixel, Scene};
use fovol_render::cpu::Renderer;
use fovol_render::scene::RayResult;

/// A pixel of a frame.
const COLOUR: usize = size_of::<[f32; 4]>();
/// A pixel that was marched, and what its ray brought back.
const MARCHED: usize = size_of::<Pixel>() + size_of::<RayResult>();

/// Refuses what cannot fit into memory.
pub fn check(device: &OpenDevice, scene: &Scene, settings: &RenderSettings) -> Result<()> {
    let size = settings.frame_size();
    let estimate = Renderer::estimate(scene, Estimate::new(format!("rendering frames of {size}")));
    let estimate = match device {
        OpenDevice::Cpu => estimate.with("frames", frames(settings)),
        // Only what is uploaded is made here, and only what is read back of frames comes here.
        #[cfg(feature = "gpu")]
        OpenDevice::Gpu(_) => estimate,
    };
    Ok(estimate.check(SMALLER_BOTH).map_err(fovol_core::Error::from)?)
}

/// The bytes of the frames that are there at the same time while one is made.
fn frames(settings: &RenderSettings) -> u64 {
    let bytes = match settings.sampling() {
        // What all rays brought back, and the frame that is made of it.
        Sampling::Full => COLOUR + MARCHED,
        // The sparse frame and the full one.
        Sampling::Reject | Sampling::Direct | Sampling::Compact => 2 * COLOUR,
    };
    (settings.frame_size().pixels() * bytes) as u64
}

impl Pipeline {
    /// Refuses to make frames together with their references where both cannot fit into memory.
    ///
    /// # Errors
    /// More memory than there is.
    pub fn check_references(&self) -> Result<()> {
        let size = self.size();
        let pixels = size.pixels();
        // While the reference is made the rendered frame is there, sparse and full.
        Estimate::new(format!("rendering frames of {size} and their references"))
            .with("frames", (pixels * 2 * COLOUR) as u64)
            .with("references", (pixels * (COLOUR + MARCHED)) as u64)
            .check(SMALLER_FRAMES)
            .map_err(|shortage| Error::Core(shortage.into()))
    }
}
