#[cfg(feature = "gpu")]
use super::frames::{DeviceFrame, DoneFrame};
use super::sampled::{HostReconstruction, Sampled, Wanted};
use super::view::View;
use crate::{RenderSettings, Result};
use fovol_core::{Camera, Frame, FrameSize, Region, SampleList, Scene, ShadowMode};
use fovol_render::cpu::march::SampleCount;
use fovol_render::scene::RayResult;
use std::fmt::Debug;
use std::time::Duration;

/// Ray marcher of a pipeline. Cameras are in the space of the marched box.
pub trait Marcher: Debug + Send {
    /// Name of the GPU; `None` on the CPU.
    fn gpu_name(&self) -> Option<String>;

    /// Time that the grid of cached shadows took on the CPU, if that makes it.
    fn shadow_grid_time(&self) -> Duration;

    /// Time that the last cached shadows took, whatever shadows the scene has, if it is known.
    fn cached_shadows_time(&self) -> Option<Duration> {
        None
    }

    /// Reconstruction on the host for `settings`; one that does nothing if the marcher reconstructs by itself.
    ///
    /// # Errors
    /// Weights that cannot be used.
    fn host_reconstruction(&self, settings: &RenderSettings) -> Result<HostReconstruction>;

    /// Replaces the scene and the settings; the volume stays the same. `reconstructs_alike` tells whether the state of a
    /// reconstruction stays valid.
    ///
    /// # Errors
    /// An invalid scene, weights that cannot be used, a lost device.
    fn change(&mut self, scene: &Scene, settings: &RenderSettings, reconstructs_alike: bool) -> Result<()>;

    /// Marches the pixels of `list`; results are in list order.
    ///
    /// # Errors
    /// A list for frames of another size, a lost device.
    fn march_list(&mut self, camera: &Camera, list: &SampleList) -> Result<Vec<RayResult>>;

    /// Marches as [`Self::march_list`] does, with exact shadows even if the scene has cached ones.
    ///
    /// # Errors
    /// Errors of [`Self::march_list`].
    fn march_list_exactly(&mut self, camera: &Camera, list: &SampleList) -> Result<Vec<RayResult>>;

    /// Marches the pixels of `list` with other shadows and another step, in voxels, than those of the scene; also returns
    /// the number of samples, where it is counted. `None` if this marcher cannot do so.
    ///
    /// # Errors
    /// Too little memory for cached shadows, a lost device.
    fn march_as(
        &mut self,
        how: (ShadowMode, f64),
        camera: &Camera,
        list: &SampleList,
    ) -> Result<Option<(Vec<RayResult>, Option<SampleCount>)>>;

    /// Region of frames of `size` in which the volume can be seen.
    fn visible_region(&self, camera: &Camera, size: FrameSize) -> Option<Region>;

    /// Marches every pixel with exact shadows, even if the scene has cached ones.
    ///
    /// # Errors
    /// A lost device.
    fn reference(&mut self, camera: &Camera, size: FrameSize) -> Result<Frame>;

    /// Renders the samples of the frame of `view` with what is `wanted`, and the full frame if the marcher reconstructs by
    /// itself.
    ///
    /// # Errors
    /// A lost device.
    fn sample(&mut self, view: &View, wanted: Wanted<'_>) -> Result<Sampled>;

    /// Renders a frame that stays on the device; `None` if that is not possible.
    ///
    /// # Errors
    /// A lost device.
    #[cfg(feature = "gpu")]
    fn display(&mut self, view: &View) -> Result<Option<DeviceFrame>>;

    /// Waits for the frames of [`Self::display`] in progress; returns facts about them, in order.
    ///
    /// # Errors
    /// A lost device.
    #[cfg(feature = "gpu")]
    fn finish_display(&mut self) -> Result<Vec<DoneFrame>>;

    /// Forgets all earlier frames.
    fn reset(&mut self);
}
