use crate::{OpenVolume, RenderSettings, Result, WorldBox, presets};
use fovol_core::{Light, Scene, Shading, ShadowMode};
use glam::DVec3;

/// Scene of the whole `volume` with `settings`; for a crop box see [`crate::Clip`]. The scene is in the space of the
/// volume's box. Its light is converted here, and cameras must be converted by [`WorldBox`].
///
/// # Errors
/// Invalid settings, a transfer function that cannot be read.
pub fn scene(volume: &OpenVolume, settings: &RenderSettings) -> Result<Scene> {
    let transfer = presets::chosen(settings, volume)?;
    let mut scene = Scene::new(volume.volume.clone(), transfer);
    let defaults = Shading::default();
    let light = settings.light.map(|l| Light::towards(DVec3::from_array(l))).transpose()?;
    let light = light.unwrap_or(defaults.light).direction();
    let world = WorldBox::new(&volume.volume, settings)?;
    scene.shading = Shading {
        light: Light::towards(world.direction(light))?,
        ambient: settings.ambient.unwrap_or(defaults.ambient),
        shadows: settings.shadows.unwrap_or(ShadowMode::On),
        surface: settings.shading.unwrap_or_default(),
    };
    scene.background = settings.background.unwrap_or(scene.background);
    scene.step = settings.step.unwrap_or(scene.step);
    scene.integration = settings.integration();
    scene.check()?;
    Ok(scene)
}
