//! Lists of pixels with other shadows or another step than those of the scene.

use super::march::SampleCount;
use super::renderer::Renderer;
use crate::scene::RayResult;
use fovol_core::memory::Shortage;
use fovol_core::{Camera, SampleList, ShadowMode};

impl Renderer {
    /// Marches the pixels of `list` in full light, without shadow rays, as [`Self::march_list`] does.
    pub fn march_list_without_shadows(
        &mut self,
        camera: &Camera,
        list: &SampleList,
    ) -> (Vec<RayResult>, SampleCount) {
        self.with_shadows(ShadowMode::Off, |renderer| renderer.march_list(camera, list))
    }

    /// Marches the pixels of `list` with cached shadows, as [`Self::march_list`] does.
    ///
    /// The first such call after a change of the scene makes the grid of cached shadows.
    ///
    /// # Errors
    /// Too little memory for the grid.
    pub fn march_list_with_cached_shadows(
        &mut self,
        camera: &Camera,
        list: &SampleList,
    ) -> Result<(Vec<RayResult>, SampleCount), Shortage> {
        self.with_shadows(ShadowMode::Cached, |renderer| {
            renderer.make_shadow_grid()?;
            Ok(renderer.march_list(camera, list))
        })
    }

    /// Marches the pixels of `list` with other shadows and another step than those of the scene, as [`Self::march_list`]
    /// does. `step` is in voxels, see [`fovol_core::Scene::step`].
    ///
    /// What the step and cached shadows need is prepared by the first such call after a change of the scene. See
    /// [`Self::expect_rays`] for shadow rays.
    ///
    /// # Errors
    /// Too little memory for cached shadows.
    pub fn march_list_as(
        &mut self,
        (shadows, step): (ShadowMode, f64),
        camera: &Camera,
        list: &SampleList,
    ) -> Result<(Vec<RayResult>, SampleCount), Shortage> {
        let own = self.prepared.step;
        self.take_step(step * self.stretch);
        let marched = self.with_shadows(shadows, |renderer| {
            match shadows {
                ShadowMode::On => renderer.expect_rays(list.len()),
                ShadowMode::Cached | ShadowMode::Off => renderer.prepare_shadows()?,
            }
            Ok(renderer.march_list(camera, list))
        });
        self.take_step(own);
        marched
    }
}
