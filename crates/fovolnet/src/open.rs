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

impl OpenVolume {
    /// What somebody should know who sees little of it: values that are not finite, or all the same.
    pub fn remarks(&self) -> Vec<String> {
        let fovol_core::Statistics { min, max, non_finite, .. } = *self.volume.statistics();
        let mut remarks = Vec::new();
        if non_finite > 0 {
            remarks.push(format!(
                "{non_finite} values of {} are not finite and shown as the lowest",
                self.source
            ));
        }
        if min == max {
            remarks.push(format!(
                "all values of {} are {min}: nothing can be told apart, and most transfer functions show nothing of it",
                self.source
            ));
        }
        remarks
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn volumes_in_which_little_can_be_seen_are_remarked_on() {
        let folder = tempfile::tempdir().unwrap();
        let remarks = |name: &str, values: [f32; 8]| {
            let path = folder.path().join(name);
            std::fs::write(&path, values.map(f32::to_le_bytes).concat()).unwrap();
            open_volume(path.to_str().unwrap(), &VolumeSettings::default()).unwrap().remarks()
        };
        let usual = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];
        assert!(remarks("usual_2x2x2_float32.raw", usual).is_empty());
        let empty = remarks("empty_2x2x2_float32.raw", [3.0; 8]);
        assert!(empty.len() == 1 && empty[0].contains("are 3: nothing can be told apart"), "{empty:?}");
        let broken = remarks("broken_2x2x2_float32.raw", [f32::NAN; 8]);
        assert!(broken.len() == 2 && broken[0].starts_with("8 values of"), "{broken:?}");
    }
}
