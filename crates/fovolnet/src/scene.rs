use crate::{OpenVolume, RenderSettings, Result, presets};
use fovol_core::{Light, Scene, Shading, ShadowMode};
use glam::DVec3;

/// The scene that `settings` describe around `volume`, whole: see [`crate::Clip`] for parts.
///
/// # Errors
/// Settings that cannot be rendered with, a transfer function that cannot be read.
pub fn scene(volume: &OpenVolume, settings: &RenderSettings) -> Result<Scene> {
    let transfer = presets::find(settings.tf.as_deref().unwrap_or("auto"), volume)?;
    let mut scene = Scene::new(volume.volume.clone(), transfer);
    let defaults = Shading::default();
    scene.shading = Shading {
        light: settings
            .light
            .map(|l| Light::towards(DVec3::from_array(l)))
            .transpose()?
            .unwrap_or(defaults.light),
        ambient: settings.ambient.unwrap_or(defaults.ambient),
        shadows: settings.shadows.unwrap_or(ShadowMode::On),
        surface: settings.shading.unwrap_or_default(),
    };
    scene.background = settings.background.unwrap_or(scene.background);
    scene.step = settings.step.unwrap_or(scene.step);
    scene.check()?;
    Ok(scene)
}
