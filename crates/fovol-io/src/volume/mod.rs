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
mod units;
mod unpacked;
mod vdb;
mod voxels;
mod vti;
mod write;
#[cfg(feature = "zarr")]
mod zarr;
mod zip;

use crate::Result;
pub use array_path::split_array;
pub use detached::Beside;
use fovol_core::Volume;
pub use overrides::Overrides;
pub use source::Source;
use std::path::Path;
pub use write::{write, write_with};

/// Reads the volume at `path`, a file, a folder of slices or one of Zarr. The format is decided by the content where
/// that is possible, else by the name. `FILE:ARRAY` names an array in a file, as [`split_array`] says.
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
    if path.is_dir() {
        let volume = format::read_folder(path, overrides)?;
        return overrides.apply(&Source::from_bytes(path, Vec::new()), volume);
    }
    parse(&Source::open(path)?, overrides)
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
