//! Volume files.

mod active_box;
mod affine;
mod array_axes;
mod array_path;
mod arrays;
mod blosc;
#[cfg(any(feature = "hdf5", feature = "zarr"))]
mod cf;
mod channel_window;
mod decompress;
mod detached;
#[cfg(feature = "dicom")]
pub mod dicom;
mod format;
#[cfg(feature = "hdf5")]
mod hdf5;
mod layout;
mod legacy_vtk;
#[cfg(any(feature = "hdf5", feature = "zarr"))]
mod levels;
mod metaimage;
mod nanovdb;
#[cfg(feature = "hdf5")]
mod netcdf;
mod nifti;
mod nrrd;
mod numbers;
mod numpy;
mod overrides;
mod payload;
mod raw;
mod reals;
mod rectilinear;
mod series;
mod slice_folder;
mod source;
mod tiff_stack;
mod time_series;
mod units;
mod unpacked;
mod vdb;
mod voxels;
mod vti;
mod write;
#[cfg(feature = "zarr")]
mod zarr;
mod zip;

use crate::{Error, Result};
pub use array_path::{is_remote, split_array};
pub use detached::Beside;
use fovol_core::Volume;
pub use overrides::Overrides;
pub use source::Source;
use std::path::{Path, PathBuf};
pub use time_series::is_pattern;
pub use write::{write, write_with};

/// Reads the volume at `path`, a file, a folder of slices or one of Zarr. The format is decided by the content where
/// that is possible, else by the name. A folder of volumes, or a pattern such as `run_*.vti`, is a time series.
///
/// `FILE:ARRAY` names an array in a file, as [`split_array`] says. An address, as [`is_remote`] says, is that of a folder
/// or a zip archive of Zarr.
///
/// # Errors
/// A file that is missing, damaged or of no known kind; one line that says how to mend it.
pub fn read(path: &Path, overrides: &Overrides) -> Result<Volume> {
    if let (file, Some(array)) = split_array(path) {
        let chosen = overrides.with_array(&file, array)?;
        if file.is_dir() {
            return read(&file, &chosen);
        }
        return parse(&Source::open(&file)?, &chosen);
    }
    if is_remote(path) {
        return read_remote(path, overrides);
    }
    if is_pattern(path) {
        return read_series(path, &time_series::files_of_pattern(path)?, overrides);
    }
    if path.is_dir() {
        let Some(volume) = format::read_folder(path, overrides)? else {
            return read_series(path, &time_series::files_in_folder(path)?, overrides);
        };
        return overrides.apply(&Source::from_bytes(path, Vec::new()), volume);
    }
    parse(&Source::open(path)?, overrides)
}

/// Reads the Zarr at the address `url`, a folder or a zip archive.
#[cfg(feature = "remote")]
fn read_remote(url: &Path, overrides: &Overrides) -> Result<Volume> {
    zarr::parse_remote(url, overrides)
}

/// Error for an address in a program that reads none.
#[cfg(not(feature = "remote"))]
fn read_remote(url: &Path, _: &Overrides) -> Result<Volume> {
    Err(Error::unsupported(
        url,
        "Zarr on the web is read only with the cargo feature `remote` of fovol-io; build with it, or download the volume",
    ))
}

/// Reads one of `files`, the time points of the series `path`.
fn read_series(path: &Path, files: &[PathBuf], overrides: &Overrides) -> Result<Volume> {
    if files.is_empty() {
        return Err(Error::unsupported(
            path,
            "it is a folder without slices of DICOM, TIFF, PNG, JPEG or BMP, and without several volumes; name a volume file",
        ));
    }
    let (time, file) = time_series::chosen(path, files, overrides)?;
    let volume = read(file, &Overrides { time: None, ..overrides.clone() })?;
    time_series::placed(volume, file, [time, files.len()])
}

/// Reads the volume in `source`, as [`read`] does.
///
/// # Errors
/// Those of [`read`].
pub fn parse(source: &Source, overrides: &Overrides) -> Result<Volume> {
    if let Some(unpacked) = unpacked::unpacked(source)? {
        return parse(&unpacked, overrides);
    }
    let volume = match format::parser_of(source)? {
        Some(parser) => parser(source, overrides)?,
        None => raw::parse(source, overrides)?,
    };
    overrides.apply(source, volume)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_without_slices_say_so() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("notes.txt"), "of the scan").unwrap();
        let said = read(folder.path(), &Overrides::default()).unwrap_err().to_string();
        assert!(said.contains("without slices"), "{said}");
    }
}
