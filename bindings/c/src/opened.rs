use crate::handles::shared;
use crate::status::Failure;
use crate::transfer_function::FovolnetTransferFunction;
use crate::volume::FovolnetVolume;
use fovolnet::core::Volume;
use fovolnet::{ComponentChoice, OpenVolume, TimeChoice, TransferChoice, VolumeSettings, open_volume};
use std::sync::Arc;

/// Voxels of a volume.
#[derive(Clone, Default)]
pub enum Source {
    /// None yet.
    #[default]
    Nothing,
    /// Path or name.
    Named(String),
    /// In the memory of the caller.
    Lent(OpenVolume),
}

/// Pending parameters of a volume.
#[derive(Clone, Default)]
pub struct VolumeParameters {
    pub source: Source,
    pub settings: VolumeSettings,
    pub overlays: Vec<Overlaid>,
}

/// Further volume, and its transfer function.
#[derive(Clone)]
pub struct Overlaid {
    pub volume: Arc<FovolnetVolume>,
    pub transfer_function: Option<Arc<FovolnetTransferFunction>>,
}

impl Overlaid {
    /// Overlay of two handles.
    ///
    /// # Safety
    /// Both are null, or were handed out and not released.
    pub unsafe fn of(
        volume: *const FovolnetVolume,
        transfer_function: *const FovolnetTransferFunction,
    ) -> Result<Self, Failure> {
        // SAFETY: the caller promises it.
        let (volume, transfer_function) = unsafe { (shared(volume), shared(transfer_function)) };
        let volume = volume.ok_or_else(|| Failure::invalid("`overlay` is NULL; give a volume"))?;
        Ok(Self { volume, transfer_function })
    }
}

impl VolumeParameters {
    /// Volume with these parameters.
    pub fn open(&self) -> Result<OpenVolume, Failure> {
        if let Some(time @ TimeChoice::Clip { .. }) = self.settings.time {
            return Err(Failure::invalid(format!(
                "time: {time} is a clip, and a volume shows one time point; set its number, and commit again for the next one"
            )));
        }
        let mut opened = match &self.source {
            Source::Nothing => {
                return Err(Failure::invalid(
                    "the volume has no voxels; call fovolnet_volume_set_source or fovolnet_volume_set_voxels first",
                ));
            }
            Source::Named(source) => open_volume(source, &self.settings)?,
            Source::Lent(lent) => in_memory(lent, &self.settings)?,
        };
        for (number, Overlaid { volume, transfer_function }) in self.overlays.iter().enumerate() {
            let mut over = OpenVolume::clone(&*volume.opened()?);
            // Volumes of one name would count as channels of one file.
            if over.source == opened.source {
                over.source = format!("overlay {}", number + 1);
            }
            let choice = match transfer_function {
                Some(function) => function.choice()?,
                None => TransferChoice::Auto,
            };
            opened = opened.with_layer(over, choice)?;
        }
        Ok(opened)
    }
}

/// Voxels of the caller with those of `settings` that are not for files.
fn in_memory(lent: &OpenVolume, settings: &VolumeSettings) -> Result<OpenVolume, Failure> {
    check_settings_of_memory(settings)?;
    let mut volume = Volume::clone(&lent.volume);
    if let Some(spacing) = settings.spacing {
        volume = volume.with_spacing(spacing)?;
    }
    if let Some(range) = settings.shown_range() {
        volume = volume.with_range(range)?;
    }
    let colours = match settings.component {
        None => volume.contents().are_colours,
        Some(ComponentChoice::Colours(_)) => true,
        Some(ComponentChoice::Number(component)) => {
            volume = volume.with_component(component)?;
            false
        }
    };
    if let Some(factor) = settings.downsample {
        volume = volume.downsampled(factor)?;
    }
    if !colours {
        return Ok(OpenVolume { volume: Arc::new(volume), ..lent.clone() });
    }
    let (colours, opacity) = volume.colours()?;
    Ok(OpenVolume { volume: Arc::new(opacity), colours: Some(colours), ..lent.clone() })
}

/// Refuses settings that only files have.
fn check_settings_of_memory(settings: &VolumeSettings) -> Result<(), Failure> {
    let VolumeSettings { spacing, range, window, component, downsample, overlay, .. } = settings.clone();
    let for_memory =
        VolumeSettings { spacing, range, window, component, downsample, ..VolumeSettings::default() };
    if overlay.is_some() {
        return Err(Failure::invalid(
            "voxels in memory take no setting \"overlay\"; call fovolnet_volume_add_overlay instead",
        ));
    }
    if *settings != for_memory {
        return Err(Failure::invalid(
            "voxels in memory take the settings spacing, range, window, component and downsample; take others back with \
             fovolnet_volume_unset",
        ));
    }
    Ok(())
}
