use super::ray_mode::ray_mode;
use crate::{OpenVolume, RenderSettings, Result, WorldBox, presets};
use fovol_core::{ClipBox, Light, Scene, Shading};

/// Scene of the whole `volume` with `settings`; for a crop box see [`crate::CroppedVolume`]. The scene is in the space of the
/// volume's box. Its light is converted here, and cameras must be converted by [`WorldBox`].
///
/// # Errors
/// Invalid settings, a transfer function that cannot be read.
pub fn scene(volume: &OpenVolume, settings: &RenderSettings) -> Result<Scene> {
    let transfer = presets::chosen(settings, volume)?;
    let mut scene = Scene::new(volume.volume.clone(), transfer);
    let world = WorldBox::new(&volume.volume, settings)?;
    scene.shading = Shading {
        light: Light::towards(world.direction(settings.light.direction()))?,
        ambient: settings.ambient,
        shadows: settings.shadows,
        surface: settings.shading,
    };
    scene.background = settings.background;
    scene.step = settings.step;
    scene.integration = settings.integration;
    scene.mode = ray_mode(&volume.volume, settings)?;
    if !settings.planes.as_slice().is_empty() {
        scene.clip = Some(ClipBox::whole(volume.volume.grid()).with_planes(world.planes(&settings.planes)));
    }
    scene.check()?;
    Ok(scene)
}
