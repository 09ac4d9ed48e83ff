//! Reference frames: every pixel marched, with exact shadows.

use super::{Marcher, Pipeline};
use crate::Result;
use fovol_core::{Camera, Frame, FrameSize, SampleList};
use fovol_render::scene::RayResult;

impl Pipeline {
    /// Reference of frame `i`: every pixel marched, with exact shadows even if the settings have cached ones. A
    /// transparent background and disabled shadows stay as the settings say.
    ///
    /// # Errors
    /// A lost device.
    pub fn reference(&mut self, i: u32) -> Result<Frame> {
        if self.settings.is_transparent() {
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
        self.march_with(Marcher::march_list_exactly, camera, list)
    }
}

impl Marcher {
    fn march_list_exactly(&mut self, camera: &Camera, list: &SampleList) -> Result<Vec<RayResult>> {
        match self {
            Self::Cpu(marcher) => Ok(marcher.march_list_exactly(camera, list)),
            #[cfg(feature = "gpu")]
            Self::Gpu(marcher) => marcher.march_list_exactly(camera, list),
        }
    }

    fn reference(&mut self, camera: &Camera, size: FrameSize) -> Result<Frame> {
        match self {
            Self::Cpu(marcher) => Ok(marcher.reference(camera, size)),
            #[cfg(feature = "gpu")]
            Self::Gpu(marcher) => marcher.reference(camera),
        }
    }
}
