//! Estimate of a pipeline's memory, checked before any is allocated.

use crate::{Guide, OpenDevice, RenderSettings, Result, Sampling};
use fovol_core::memory::{Estimate, SMALLER_BOTH};
use fovol_core::{Pixel, Scene};
use fovol_render::cpu::Renderer;
use fovol_render::scene::RayResult;

/// Bytes of one pixel of a frame.
pub const COLOUR: usize = size_of::<[f32; 4]>();
/// Bytes of one pixel of a full frame and its colour, as they are marched.
pub const MARCHED: usize = size_of::<Pixel>() + size_of::<[f32; 3]>();

/// Checks that a pipeline on `device` fits into memory.
///
/// # Errors
/// Too little memory.
pub fn fits_into_memory(device: &OpenDevice, scene: &Scene, settings: &RenderSettings) -> Result<()> {
    let size = settings.size;
    let estimate = Renderer::estimate(scene, Estimate::new(format!("rendering frames of {size}")));
    let estimate = match device {
        OpenDevice::Cpu => estimate.with("frames", frames(settings)).with("guide", guide(settings)),
        // On a GPU the host memory holds only uploads and read-backs.
        #[cfg(feature = "gpu")]
        OpenDevice::Gpu(_) => estimate,
    };
    Ok(estimate.check(SMALLER_BOTH).map_err(fovol_core::Error::from)?)
}

/// Bytes of the frames that exist at the same time while one is rendered.
fn frames(settings: &RenderSettings) -> u64 {
    let bytes = match settings.sampling {
        // All ray results, and the frame made from them.
        Sampling::Full => COLOUR + MARCHED,
        // The part of the frame that a network fills, and the frame.
        Sampling::Reject | Sampling::Direct | Sampling::Compact => 2 * COLOUR,
    };
    (settings.size.pixels() * bytes) as u64
}

/// Bytes of the guide of a frame: its marched pixels, and the guide of every pixel with its rows before.
fn guide(settings: &RenderSettings) -> u64 {
    let marched = size_of::<Pixel>() + size_of::<RayResult>() + COLOUR;
    let bytes = match settings.guide_kind() {
        Guide::None => 0,
        Guide::Quarter | Guide::Cached => marched / 4 + COLOUR / 2 + COLOUR,
        Guide::Full => marched + COLOUR,
    };
    (settings.size.pixels() * bytes) as u64
}
