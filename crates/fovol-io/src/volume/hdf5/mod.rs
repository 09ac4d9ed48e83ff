//! HDF5 and NetCDF-4: <https://support.hdfgroup.org/documentation/hdf5/latest/_f_m_t3.html>.
//!
//! Any dataset of numbers with two axes or more is a volume whose last axis is x. Files of BigDataViewer and Imaris
//! have levels, channels and time points, which are chosen as such.

mod big_data_viewer;
mod element;
mod file;
mod imaris;
mod limits;
mod lzf;
mod packed;
mod spacing;
mod voxels;

use super::array_axes::{ArrayAxes, likeliest};
use super::cf::{Attributes, Described, Spaced, auxiliary, stated_spacing, unpacked, with_spacing_notes};
use super::layout::Layout;
use super::{Overrides, Source};
use crate::Result;
pub use element::unsigned;
use element::{Element, check_bits};
use file::{File, Named, attributes};
use fovol_core::{Contents, Dtype, Volume};
use hdf5_reader::Dataset;
use spacing::Scale;

/// Whether `bytes` are those of an HDF5 file, after a block of the user's own or not.
pub fn is_hdf5(bytes: &[u8]) -> bool {
    file::start(bytes).is_some()
}

/// Reads the chosen dataset, else the only one that is a volume, else the largest.
///
/// # Errors
/// Damaged files, no dataset that is a volume, types and compressions that are not read, too little memory.
pub fn parse(source: &Source, overrides: &Overrides) -> Result<Volume> {
    let file = File::open(source)?;
    if file.group("/minc-2.0").is_some() {
        return Err(source
            .unsupported("MINC is not read; convert it to NIfTI, with `mnc2nii IN.mnc OUT.nii` for one"));
    }
    if overrides.array.is_none() {
        if let Some(volume) = big_data_viewer::parse(&file, overrides)? {
            return Ok(volume);
        }
        if let Some(volume) = imaris::parse(&file, overrides)? {
            return Ok(volume);
        }
    }
    let (mut datasets, outside) = file.datasets()?;
    // Links lead to datasets by more paths than are listed.
    if let Some(chosen) = &overrides.array
        && datasets.iter().all(|(path, _)| trimmed(path) != trimmed(chosen))
        && let Some(dataset) = file.dataset(chosen)?
    {
        datasets.push((format!("/{}", trimmed(chosen)), dataset));
    }
    let is_netcdf = is_netcdf(&file, &datasets);
    let mut candidates: Vec<Candidate<'_>> = datasets
        .iter()
        .map(|(path, dataset)| {
            // NetCDF calls variables of the root by their names alone.
            let is_variable = is_netcdf && path.rfind('/') == Some(0);
            let name = if is_variable { trimmed(path) } else { path };
            Candidate::of(&file, name, dataset, &datasets)
        })
        .collect();
    let auxiliary = auxiliary(candidates.iter().map(|candidate| &candidate.attributes));
    for candidate in &mut candidates {
        candidate.is_auxiliary |= auxiliary.contains(candidate.path.rsplit('/').next().unwrap_or_default());
    }
    let volume = shown(source, &candidates, overrides, &outside)?.volume(&file, overrides, &candidates)?;
    let volume = volume.with_format(if is_netcdf { "NetCDF-4" } else { "HDF5" });
    Ok(match outside.as_slice() {
        [] => volume,
        links => volume.with_note(format!("links to other files are not followed: {}", links.join(", "))),
    })
}

/// A dataset, and what it would be as a volume.
struct Candidate<'a> {
    path: &'a str,
    dataset: &'a Dataset,
    attributes: Attributes,
    /// Whether it holds bounds or coordinates of other datasets.
    is_auxiliary: bool,
    scales: Vec<Option<Scale<'a>>>,
    element: std::result::Result<Element, String>,
    axes: std::result::Result<ArrayAxes, String>,
}

impl<'a> Candidate<'a> {
    fn of(file: &File<'_>, path: &'a str, dataset: &'a Dataset, all: &'a [Named]) -> Self {
        let attributes = attributes(&dataset.attributes());
        let element = Element::of(dataset.dtype());
        let scales = spacing::scales(file, dataset, all);
        let axes = element.as_ref().map_err(|problem| format!("has values that are {problem}")).and_then(
            |element| {
                let names = match scales.is_empty() {
                    true => spacing::labels(dataset),
                    false => scales.iter().map(|scale| Some(scale.as_ref()?.name.clone())).collect(),
                };
                let first_units = scales.first().and_then(|scale| scale.as_ref()?.units());
                Described { shape: shape(dataset, element), names, first_units }.axes()
            },
        );
        let is_auxiliary = spacing::is_scale(&attributes);
        Self { path, dataset, attributes, is_auxiliary, scales, element, axes }
    }

    /// Whether the dataset is a volume of its own, rather than coordinates of others.
    fn is_volume(&self) -> bool {
        self.axes.is_ok() && !self.is_auxiliary
    }

    fn volume(&self, file: &File<'_>, overrides: &Overrides, all: &[Self]) -> Result<Volume> {
        let source = file.source;
        let refused = |problem: &String| source.unsupported(format!("its dataset {} {problem}", self.path));
        let axes = self.axes.as_ref().map_err(refused)?;
        let element = self.element.as_ref().map_err(refused)?;
        self.dataset.raw_datatype().map_or(Ok(()), |raw| check_bits(&raw, element.dtype)).map_err(
            |problem| source.unsupported(format!("its dataset {} has values that are {problem}", self.path)),
        )?;
        let time = overrides.time_of(source, axes.times)?;
        let spaced = self.spaced(axes);
        let layout = Layout {
            spacing: spaced.as_ref().map_or([1.0; 3], |spaced| spaced.spacing),
            endian: element.endian,
            components: axes.components,
            ..Layout::new(axes.dims, self.dtype(element))
        };
        layout.length(source)?;
        let mut part: Vec<_> = self.dataset.shape().iter().map(|&length| 0..length as usize).collect();
        if let Some(axis) = axes.time.filter(|_| axes.times > 1)
            && let Some(range) = part.get_mut(axis)
        {
            *range = time..time + 1;
        }
        let (bytes, start) = voxels::read(file, self.dataset, element, &part)?;
        let listed: Vec<&Self> =
            all.iter().filter(|other| other.is_volume() || other.path == self.path).collect();
        let contents = Contents {
            arrays: listed.iter().map(|array| array.path.to_owned()).collect(),
            array: listed.iter().position(|array| array.path == self.path).unwrap_or_default(),
            ..axes.contents(time)
        };
        let volume = layout.volume(source, bytes, start)?.with_contents(contents);
        let volume = axes.notes.iter().fold(volume, |volume, note| volume.with_note(note.as_str()));
        let volume = with_spacing_notes(volume, spaced.as_ref(), overrides);
        let volume = match self.attributes.number("realWorldMapping_scale") {
            Some(scale) if scale != 1.0 => volume.with_note(format!(
                "its real-world mapping of Voreen (scale {scale}) is not applied; values are shown as they are stored"
            )),
            _ => volume,
        };
        unpacked(source, volume, &self.attributes)
    }

    /// The type of the values, which NetCDF files may call unsigned in an attribute.
    fn dtype(&self, element: &Element) -> Dtype {
        let is_unsigned =
            self.attributes.text("_Unsigned").is_some_and(|text| text.eq_ignore_ascii_case("true"));
        if is_unsigned { unsigned(element.dtype) } else { element.dtype }
    }

    fn spaced(&self, axes: &ArrayAxes) -> Option<Spaced> {
        stated_spacing(&self.attributes).or_else(|| spacing::of_scales(&self.scales, axes))
    }
}

/// Lengths of all axes of `dataset`, those of its values too.
fn shape(dataset: &Dataset, element: &Element) -> Vec<usize> {
    let outer = dataset.shape().iter().map(|&length| usize::try_from(length).unwrap_or(usize::MAX));
    outer.chain(element.inner.iter().copied()).collect()
}

/// Whether the NetCDF library wrote the file.
fn is_netcdf(file: &File<'_>, datasets: &[Named]) -> bool {
    let root = file.group("/").and_then(|root| root.attributes().ok()).unwrap_or_default();
    root.iter().any(|attribute| attribute.name == "_NCProperties")
        || datasets.iter().any(|(_, dataset)| {
            dataset.attributes().iter().any(|attribute| attribute.name.starts_with("_Netcdf4"))
        })
}

/// `path` without slashes at its ends.
fn trimmed(path: &str) -> &str {
    path.trim_matches('/')
}

/// The dataset to show.
fn shown<'a, 'b>(
    source: &Source,
    candidates: &'a [Candidate<'b>],
    overrides: &Overrides,
    outside: &[String],
) -> Result<&'a Candidate<'b>> {
    if let Some(chosen) = &overrides.array {
        let found = candidates.iter().find(|candidate| trimmed(candidate.path) == trimmed(chosen));
        return found.ok_or_else(|| {
            if let Some(link) =
                outside.iter().find(|link| link.starts_with(&format!("/{} in ", trimmed(chosen))))
            {
                return source.unsupported(format!("{link} is a link to another file; name that file"));
            }
            let volumes = candidates.iter().filter(|candidate| candidate.is_volume());
            let names: Vec<String> = volumes.map(|candidate| candidate.path.to_owned()).collect();
            Overrides::no_array(source, chosen, &names)
        });
    }
    let volumes =
        candidates.iter().map(|candidate| candidate.axes.as_ref().ok().filter(|_| candidate.is_volume()));
    match (likeliest(volumes), candidates) {
        (Some(index), _) => Ok(&candidates[index]),
        (None, [only]) => Ok(only),
        (None, []) => Err(source.unsupported(match outside {
            [] => "it holds no datasets; is it the right file?".to_owned(),
            [link, ..] => format!("it holds only links to other files, {link} for one; name that file"),
        })),
        (None, _) => {
            Err(source.unsupported("none of its datasets is a volume; save one with the axes z, y, x"))
        }
    }
}

#[cfg(test)]
mod tests;
