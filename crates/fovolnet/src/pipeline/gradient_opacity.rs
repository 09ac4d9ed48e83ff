//! Scenes whose opacity depends on the gradient: they are rendered on the processor.

use crate::{Device, Error, OpenDevice, Result, SpeedSettings};
use fovol_core::{Integration, Interpolation, Scene};

/// The device for `scene`: `device`, but the CPU if the opacity depends on the gradient; and a note if another was not
/// asked for.
///
/// # Errors
/// A GPU that was asked for and cannot show the scene.
pub fn device_for(
    device: &OpenDevice,
    scene: &Scene,
    speed: &SpeedSettings,
) -> Result<(OpenDevice, Option<String>)> {
    if !scene.has_gradient_opacity() || matches!(device, OpenDevice::Cpu) {
        return Ok((device.clone(), None));
    }
    let what = "opacity by gradient is rendered on the processor";
    match speed.device() {
        Device::Auto => Ok((OpenDevice::Cpu, Some(what.to_owned()))),
        _ => Err(Error::Setting(format!(
            "{what}; leave out --device gpu, or \"gradient\" of the transfer function"
        ))),
    }
}

/// Note that the integration of `scene` is not the fine one, because its opacity depends on the gradient.
pub fn integration_note(scene: &Scene) -> Option<String> {
    let would_be_fine = scene.integration == Integration::Fine
        && scene.interpolation == Interpolation::Linear
        && !scene.is_layered();
    (scene.has_gradient_opacity() && would_be_fine)
        .then(|| "opacity by gradient is integrated as --integration plain does".to_owned())
}
