//! Reference frames: every pixel marched, with exact shadows.

use super::Pipeline;
use super::estimate::{COLOUR, MARCHED};
use crate::{Error, Result};
use fovol_core::memory::{Estimate, SMALLER_FRAMES};
use fovol_core::{Camera, Frame, SampleList};
use fovol_render::scene::RayResult;

impl Pipeline {
    /// Reference of frame `i`: every pixel marched, with exact shadows even if the settings have cached ones. A
    /// transparent background and disabled shadows stay as the settings say.
    ///
    /// # Errors
    /// A lost device.
    pub fn reference(&mut self, i: u32) -> Result<Frame> {
        if self.settings.transparent {
            return self.transparent_reference(i);
        }
        self.opaque_reference(i)
    }

    pub(super) fn opaque_reference(&mut self, i: u32) -> Result<Frame> {
        let (camera, size) = (self.in_box(&self.camera(i)), self.size());
        let marcher = &mut self.marcher;
        self.threads.install(|| marcher.reference(&camera, size))
    }

    /// Marches the pixels of `list` as in the reference: with exact shadows even if the settings have cached ones.
    ///
    /// # Errors
    /// Errors of [`Self::march`].
    pub fn march_reference(&mut self, camera: &Camera, list: &SampleList) -> Result<Vec<RayResult>> {
        self.march_with(|marcher, camera| marcher.march_list_exactly(camera, list), camera)
    }

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
