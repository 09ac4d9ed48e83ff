use super::ray_mode::ray_mode;
use crate::{Choice, Mode, OpenLayer, OpenVolume, RenderSettings, Result, WorldBox, presets};
use fovol_core::{ClipBox, Interpolation, Layer, Light, Scene, Shading, Volume};

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
    scene.interpolation = interpolation(&volume.volume, settings);
    scene.mode = ray_mode(&volume.volume, settings)?;
    scene.colours.clone_from(&volume.colours);
    scene.layers =
        volume.layers.iter().map(|layer| layer_of(layer, settings)).collect::<Result<Vec<Layer>>>()?;
    if !settings.planes.as_slice().is_empty() {
        scene.clip = Some(ClipBox::whole(volume.volume.grid()).with_planes(world.planes(&settings.planes)));
    }
    scene.check()?;
    Ok(scene)
}

fn layer_of(layer: &OpenLayer, settings: &RenderSettings) -> Result<Layer> {
    let opened = &layer.opened;
    Ok(Layer {
        volume: opened.volume.clone(),
        transfer_function: presets::of_choice(&layer.transfer_function, opened)?,
        colours: opened.colours.clone(),
        interpolation: interpolation(&opened.volume, settings),
    })
}

/// How values between voxels of `volume` are found with `settings`. Greatest, least and mean values are always those of
/// trilinear interpolation.
fn interpolation(volume: &Volume, settings: &RenderSettings) -> Interpolation {
    match settings.interpolation {
        _ if matches!(settings.mode, Mode::Mip | Mode::Minip | Mode::Average) => Interpolation::Linear,
        Choice::Fixed(interpolation) => interpolation,
        Choice::Auto if volume.is_label_map() => Interpolation::Nearest,
        Choice::Auto => Interpolation::Linear,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovol_core::{Contents, Grid};

    #[test]
    fn labels_are_not_interpolated() {
        let of =
            |values: Vec<u8>| Volume::from_values(Grid::new([4, 2, 1], [1.0; 3]).unwrap(), values).unwrap();
        let labels = of(vec![0, 0, 3, 3, 0, 1, 1, 3]);
        let ramp = of(vec![0, 1, 2, 3, 0, 1, 2, 3]);
        let usual = RenderSettings::default();
        assert_eq!(interpolation(&labels, &usual), Interpolation::Nearest);
        assert_eq!(interpolation(&ramp, &usual), Interpolation::Linear);
        let declared = ramp.with_contents(Contents { are_labels: true, ..Contents::default() });
        assert_eq!(interpolation(&declared, &usual), Interpolation::Nearest);
        let mip = RenderSettings { mode: Mode::Mip, ..usual.clone() };
        assert_eq!(interpolation(&labels, &mip), Interpolation::Linear);
        let linear = RenderSettings { interpolation: Interpolation::Linear.into(), ..usual };
        assert_eq!(interpolation(&labels, &linear), Interpolation::Linear);
    }
}
