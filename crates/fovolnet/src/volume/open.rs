use crate::{Error, Result, TransferChoice, VolumeSettings};
use fovol_core::{Contents, Dtype, Rescale, Volume, VoxelColours, did_you_mean, path_of_text};
use fovol_io::dataset;
use fovol_io::procedural::{self, Procedural};
use std::path::Path;
use std::sync::Arc;

/// Opened volume, its origin, and what is shown with it.
#[derive(Debug, Clone)]
pub struct OpenVolume {
    /// The volume.
    pub volume: Arc<Volume>,
    /// Path or procedural name that opened the volume.
    pub source: String,
    /// Kind of procedural volume, if it is one.
    pub procedural: Option<Procedural>,
    /// Colours of the voxels, if they have some; the volume then holds what decides opacity.
    pub colours: Option<VoxelColours>,
    /// Further volumes at the same points, with as many voxels along each axis.
    pub layers: Vec<OpenLayer>,
}

/// A further volume, with the voxels of the first.
#[derive(Debug, Clone)]
pub struct OpenLayer {
    /// The volume and its origin.
    pub opened: OpenVolume,
    /// Its transfer function.
    pub transfer_function: TransferChoice,
}

impl From<Volume> for OpenVolume {
    /// Volume made in memory. Notes call it "the volume".
    fn from(volume: Volume) -> Self {
        Self::of(Arc::new(volume), "the volume")
    }
}

impl OpenVolume {
    /// A volume alone, whose notes call it `source`.
    pub fn of(volume: Arc<Volume>, source: impl Into<String>) -> Self {
        Self { volume, source: source.into(), procedural: None, colours: None, layers: Vec::new() }
    }

    /// Warnings that explain why little may be visible: values that are not finite, or that are all equal.
    pub fn remarks(&self) -> Vec<String> {
        let fovol_core::Statistics { min, max, non_finite, nan, .. } = *self.volume.statistics();
        let mut remarks = Vec::new();
        if nan > 0 {
            remarks.push(format!(
                "{nan} values of {} are NaN; what touches them is transparent, or has the colour of --nan R,G,B,A",
                self.source
            ));
        }
        let infinite = non_finite - nan;
        if infinite > 0 {
            remarks
                .push(format!("{infinite} values of {} are infinite and shown as the lowest", self.source));
        }
        if min == max {
            remarks.push(format!(
                "all values of {} are {min}: nothing can be told apart, and most transfer functions show nothing of it",
                self.source
            ));
        }
        remarks
    }

    /// Notes on doubts while reading the file, and on values that are shown in unexpected ways; one line each.
    pub fn doubts(&self) -> Vec<String> {
        let narrow =
            self.narrow_range().map(|range| format!("{}: {}", self.source, shown_range(&self.volume, range)));
        // Labels have colours at their own values, wherever the range ends.
        let narrow = narrow.filter(|_| !self.volume.is_label_map() && self.colours.is_none());
        let notes = self.volume.notes().iter().map(|note| format!("{}: {note}", self.source));
        notes.chain(narrow).chain(self.outliers()).chain(self.labels()).collect()
    }

    /// Notes for the user, one line each: [`Self::doubts`], other contents of the file, and those of further volumes.
    pub fn notes(&self) -> Vec<String> {
        let besides =
            self.contents_besides().notes().into_iter().map(|note| format!("{} {note}", self.source));
        let of_layers = self.layers.iter().filter(|layer| layer.opened.source != self.source);
        let of_layers = of_layers.flat_map(|layer| layer.opened.notes());
        self.doubts().into_iter().chain(besides).chain(self.blended_channels()).chain(of_layers).collect()
    }

    /// Contents of the file, without what is shown already.
    fn contents_besides(&self) -> Contents {
        let mut contents = self.volume.contents().clone();
        if self.colours.is_some() {
            contents.components = 1;
        }
        if self.channels().len() > 1 {
            contents.channels.clear();
        }
        contents
    }

    /// Channels of the file that are shown.
    pub fn channels(&self) -> Vec<usize> {
        let others = self.layers.iter().filter(|layer| layer.opened.source == self.source);
        let others = others.map(|layer| layer.opened.volume.contents().channel);
        std::iter::once(self.volume.contents().channel).chain(others).collect()
    }

    /// Note on channels that are blended.
    fn blended_channels(&self) -> Option<String> {
        let shown = self.channels();
        let all = &self.volume.contents().channels;
        if shown.len() < 2 {
            return None;
        }
        let named = |channel: &usize| match all.get(*channel).map(String::as_str) {
            None | Some("") => channel.to_string(),
            Some(name) => format!("{channel} ({name})"),
        };
        let names: Vec<String> = shown.iter().map(named).collect();
        Some(format!(
            "{} has {} channels, {} are blended; --channel C chooses one, or others such as 0,2",
            self.source,
            all.len(),
            names.join(", ")
        ))
    }

    /// Note on a label map, if the volume looks like one.
    fn labels(&self) -> Option<String> {
        let why = match self.volume.label_values() {
            _ if self.volume.contents().are_labels => "its file says that its values are labels".to_owned(),
            Some(_) if self.colours.is_some() => return None,
            Some(labels) => format!("its {} values look like labels", labels.len()),
            None => return None,
        };
        Some(format!(
            "{}: {why}; voxels are shown without interpolation, unless --interpolation linear is given",
            self.source
        ))
    }

    /// Note on values far outside all others, if there are any.
    fn outliers(&self) -> Option<String> {
        let volume = &self.volume;
        let outliers = &volume.statistics().outliers;
        let has_usual_range = volume.dtype() == Dtype::U8 && volume.rescale() == Rescale::IDENTITY;
        if outliers.is_empty() || volume.range_is_chosen() || has_usual_range {
            return None;
        }
        let values: Vec<String> = outliers
            .iter()
            .map(|outlier| format!("{} (in {} voxels)", outlier.value, outlier.count))
            .collect();
        let [lo, hi] = volume.range();
        Some(format!(
            "{}: {} lies far outside all other values and is left out of the range, {lo} to {hi}; --range LO,HI chooses another",
            self.source,
            values.join(" and ")
        ))
    }

    /// Smallest and largest value, if they fill only a small part of the usual range of 8-bit volumes.
    pub(crate) fn narrow_range(&self) -> Option<[f64; 2]> {
        let volume = &self.volume;
        let has_usual_range =
            volume.dtype() == Dtype::U8 && volume.rescale() == Rescale::IDENTITY && !volume.range_is_chosen();
        let fovol_core::Statistics { min, max, .. } = *volume.statistics();
        let is_narrow = min < max && max - min < NARROW * 255.0;
        (has_usual_range && is_narrow && self.procedural.is_none()).then_some([min, max])
    }
}

/// Fraction of the 8-bit range below which values count as narrow.
const NARROW: f64 = 0.25;

/// Explains how values from `lo` to `hi` of `volume` are shown, and which range shows more of them.
pub(crate) fn shown_range(volume: &Volume, [lo, hi]: [f64; 2]) -> String {
    let [from, to] = [lo, hi].map(|value| (1000.0 * volume.normalised(value)).round() / 1000.0);
    format!("values {lo} to {hi} are shown as {from} to {to} of the range; try --range {lo},{hi}")
}

/// Opens the one volume `source`: a file or folder, or a procedural volume if no file has that name. Procedural volumes have 128³
/// voxels unless the settings say otherwise. Paths that are not Unicode are written by [`fovol_core::text_of_path`].
///
/// Files need the cargo feature `files`, procedural volumes the feature `procedural`.
///
/// # Errors
/// A file that is missing, unreadable or invalid.
pub fn open_single_volume(source: &str, settings: &VolumeSettings) -> Result<OpenVolume> {
    if let Some([overlay, ..]) = settings.overlay.as_deref() {
        return Err(Error::Setting(format!(
            "--overlay {overlay} has no place here, where one volume is read; leave it out"
        )));
    }
    let path = path_of_text(source);
    let procedural = if path.exists() { None } else { source.parse::<Procedural>().ok() };
    let volume = match procedural {
        Some(kind) => made(kind, settings)?,
        None if !path.exists() && !is_pattern(&path) && !source.contains(['.', '/', '\\']) => {
            return Err(unknown(source));
        }
        None => read(&path, settings)?,
    };
    let volume = match settings.downsample {
        Some(factor) => volume.downsampled(factor)?,
        None => volume,
    };
    Ok(OpenVolume { procedural, ..OpenVolume::of(Arc::new(volume), source) })
}

/// Error for the name `source`, which is neither a file nor a procedural volume.
fn unknown(source: &str) -> Error {
    if let Ok(entry) = dataset::find(source) {
        let (name, file) = (&entry.name, entry.file_name());
        return Error::Setting(format!(
            "`{source}` is no file here, but a published volume; `fovolnet data get {name}` downloads {file}"
        ));
    }
    let names = procedural::names();
    Error::Setting(format!(
        "`{source}` is no file and no procedural volume; check the path, or use one of {}{}",
        names.join(", "),
        did_you_mean(source, &names)
    ))
}

/// Reads the volume at `path` with `settings`.
#[cfg(feature = "files")]
fn read(path: &Path, settings: &VolumeSettings) -> Result<Volume> {
    Ok(fovol_io::volume::read(path, &settings.overrides())?)
}

/// Whether `path` is a pattern of files.
fn is_pattern(path: &Path) -> bool {
    #[cfg(feature = "files")]
    return fovol_io::volume::is_pattern(path);
    #[cfg(not(feature = "files"))]
    return path.to_string_lossy().contains('*');
}

/// Error for a file in a program that reads none.
#[cfg(not(feature = "files"))]
fn read(path: &Path, _: &VolumeSettings) -> Result<Volume> {
    let path = path.display();
    Err(Error::Setting(format!(
        "{path} is a file, which needs the cargo feature `files` of fovolnet; turn it on"
    )))
}

/// Makes the procedural volume `kind` with `settings`.
#[cfg(feature = "procedural")]
fn made(kind: Procedural, settings: &VolumeSettings) -> Result<Volume> {
    /// Voxels along each side by default.
    const PROCEDURAL_SIDE: usize = 128;
    let mut volume = procedural::make(kind, settings.dims.unwrap_or([PROCEDURAL_SIDE; 3]), 0)?;
    if let Some(range) = settings.shown_range() {
        volume = volume.with_range(range)?;
    }
    if let Some(spacing) = settings.spacing {
        volume = volume.with_spacing(spacing)?;
    }
    Ok(volume)
}

/// Error for a procedural volume in a program that makes none.
#[cfg(not(feature = "procedural"))]
fn made(kind: Procedural, _: &VolumeSettings) -> Result<Volume> {
    Err(Error::Setting(format!(
        "`{kind}` is made by the program, which needs the cargo feature `procedural` of fovolnet; turn it on"
    )))
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
            open_single_volume(path.to_str().unwrap(), &VolumeSettings::default()).unwrap().remarks()
        };
        let usual = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];
        assert!(remarks("usual_2x2x2_float32.raw", usual).is_empty());
        let empty = remarks("empty_2x2x2_float32.raw", [3.0; 8]);
        assert!(empty.len() == 1 && empty[0].contains("are 3: nothing can be told apart"), "{empty:?}");
        let (nan, inf) = (f32::NAN, f32::INFINITY);
        let some = remarks("some_2x2x2_float32.raw", [0.0, nan, 2.0, inf, -inf, -inf, nan, 7.0]);
        assert!(some.len() == 2 && some[0].starts_with("2 values of"), "{some:?}");
        assert!(some[1].starts_with("3 values of") && some[1].ends_with("shown as the lowest"), "{some:?}");
        let broken = remarks("broken_2x2x2_float32.raw", [f32::NAN; 8]);
        assert!(broken.len() == 2 && broken[0].starts_with("8 values of"), "{broken:?}");
    }

    #[test]
    fn what_is_not_shown_is_noted() {
        let folder = tempfile::tempdir().unwrap();
        let notes = |name: &str, bytes: &[u8]| {
            let path = folder.path().join(name);
            std::fs::write(&path, bytes).unwrap();
            open_single_volume(path.to_str().unwrap(), &VolumeSettings::default()).unwrap().notes()
        };
        let labels = notes("labels_2x2x2_uint8.raw", &[0, 0, 0, 0, 1, 1, 2, 2]);
        assert!(labels.len() == 1 && labels[0].contains("its 3 values look like labels"), "{labels:?}");
        let narrow = notes("narrow_2x2x2_uint8.raw", &[0, 1, 0, 1, 1, 2, 1, 2]);
        assert!(
            narrow[0].ends_with(": values 0 to 2 are shown as 0 to 0.008 of the range; try --range 0,2"),
            "{narrow:?}"
        );
        assert!(notes("scan_2x2x2_uint8.raw", &[0, 0, 1, 1, 1, 1, 200, 200]).is_empty());
        let header = b"NRRD0004\ntype: uint8\ndimension: 4\nsizes: 2 1 1 3\nencoding: raw\n\n";
        let moving = notes("moving.nrrd", &[&header[..], &[0, 255, 0, 255, 0, 255]].concat());
        assert!(
            moving.len() == 1
                && moving[0].ends_with("has 3 time points, number 0 is shown; --time N chooses another"),
            "{moving:?}"
        );
    }

    #[test]
    fn values_far_outside_all_others_are_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("terrain_2x2x2_float32.raw");
        let values = [0.0f32, 1.0, 2.0, 3.0, 4.0, 5.0, -9999.0, -9999.0];
        std::fs::write(&path, values.map(f32::to_le_bytes).concat()).unwrap();
        let open = |range| {
            open_single_volume(path.to_str().unwrap(), &VolumeSettings { range, ..Default::default() })
                .unwrap()
        };
        let opened = open(None);
        assert_eq!((opened.volume.range(), opened.volume.statistics().min), ([0.0, 5.0], -9999.0));
        let notes = opened.notes();
        assert!(notes.len() == 1 && notes[0].contains("-9999 (in 2 voxels) lies far outside"), "{notes:?}");
        assert!(open(Some([-9999.0, 5.0])).notes().is_empty());
    }

    #[test]
    fn mistyped_names_are_recognised() {
        let said = |name: &str| open_single_volume(name, &VolumeSettings::default()).unwrap_err().to_string();
        assert!(said("haed").ends_with("did you mean head?"), "{}", said("haed"));
        assert!(said("bonsai").contains("fovolnet data get bonsai"), "{}", said("bonsai"));
        assert!(said("no/such.raw").contains("cannot read no/such.raw"), "{}", said("no/such.raw"));
    }
}
