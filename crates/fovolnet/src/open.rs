use crate::{Result, VolumeSettings};
use fovol_core::Volume;
use fovol_io::procedural::{self, Procedural};
use fovol_io::volume;
use std::path::Path;
use std::sync::Arc;

/// A volume, and what is known about where it came from.
#[derive(Debug, Clone)]
pub struct OpenVolume {
    /// The volume.
    pub volume: Arc<Volume>,
    /// The path or procedural name that it was opened by.
    pub source: String,
    /// The procedural volume that it is, if it is one.
    pub procedural: Option<Procedural>,
}

/// Voxels along each side of a procedural volume, unless said otherwise.
const PROCEDURAL_SIDE: usize = 128;

/// Opens `source`: a file or folder, or (where there is none of that name) a procedural volume, of
/// 128³ voxels unless the settings give dims.
///
/// # Errors
/// What is wrong with the file, or that there is none.
pub fn open_volume(source: &str, settings: &VolumeSettings) -> Result<OpenVolume> {
    let path = Path::new(source);
    let procedural = if path.exists() { None } else { source.parse::<Procedural>().ok() };
    let volume = match procedural {
        Some(kind) => made(kind, settings)?,
        None => volume::read(path, &settings.overrides())?,
    };
    let volume = match settings.downsample {
        Some(factor) => volume.downsampled(factor)?,
        None => volume,
    };
    Ok(OpenVolume { volume: Arc::new(volume), source: source.into(), procedural })
}

/// The procedural volume `kind` as `settings` say.
fn made(kind: Procedural, settings: &VolumeSettings) -> Result<Volume> {
    let mut volume = procedural::make(kind, settings.dims.unwrap_or([PROCEDURAL_SIDE; 3]), 0)?;
    if let Some(range) = settings.range {
        volume = volume.with_range(range)?;
    }
    if let Some(spacing) = settings.spacing {
        volume = volume.with_spacing(spacing)?;
    }
    Ok(volume)
}
