//! Volume files.

mod decompress;
mod detached;
mod format;
mod layout;
mod metaimage;
mod nrrd;
mod numbers;
mod payload;
mod raw;
mod series;
mod source;
mod voxels;
mod write;

use crate::Result;
use fovol_core::{Dtype, Endian, Volume};
pub use source::Source;
use std::path::Path;
pub use write::write;

/// What a user says about a volume over the head of its file.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Overrides {
    /// Voxels along x, y, z: for bare voxels; other files say it themselves.
    pub dims: Option<[usize; 3]>,
    /// The type of one component: for bare voxels.
    pub dtype: Option<Dtype>,
    /// The byte order: for bare voxels.
    pub endian: Option<Endian>,
    /// The distance between voxels along x, y, z.
    pub spacing: Option<[f64; 3]>,
    /// The values shown as 0 and 1.
    pub range: Option<[f64; 2]>,
}

/// Reads the volume at `path`, a file or a folder of slices. The format is decided by the content where
/// that is possible, else by the name.
///
/// # Errors
/// A file that is missing, damaged or of no known kind; one line that says how to mend it.
pub fn read(path: &Path, overrides: &Overrides) -> Result<Volume> {
    if path.is_dir() {
        let volume = format::read_folder(path)?;
        return finished(&Source::from_bytes(path, Vec::new()), volume, overrides);
    }
    parse(&Source::open(path)?, overrides)
}

/// Reads the volume in `source`, as [`read`] does.
///
/// # Errors
/// As [`read`].
pub fn parse(source: &Source, overrides: &Overrides) -> Result<Volume> {
    let volume = match format::parser_of(source)? {
        Some(parser) => says_the_same(source, parser(source)?, overrides)?,
        None => raw::parse(source, overrides)?,
    };
    finished(source, volume, overrides)
}

/// `volume`, where the user claims nothing against the header of its file.
fn says_the_same(source: &Source, volume: Volume, overrides: &Overrides) -> Result<Volume> {
    let [x, y, z] = volume.grid().dims();
    if overrides.dims.is_some_and(|dims| dims != [x, y, z]) {
        return Err(source.malformed(format!("its header says {x}x{y}x{z} voxels; leave out --dims")));
    }
    if overrides.dtype.is_some_and(|dtype| dtype != volume.dtype()) {
        return Err(source.malformed(format!("its header says {}; leave out --dtype", volume.dtype())));
    }
    Ok(volume)
}

/// `volume` with the spacing and range that the user asked for.
fn finished(source: &Source, mut volume: Volume, overrides: &Overrides) -> Result<Volume> {
    if let Some(spacing) = overrides.spacing {
        volume = volume.with_spacing(spacing).map_err(|e| source.malformed(e.to_string()))?;
    }
    if let Some(range) = overrides.range {
        volume = volume.with_range(range).map_err(|e| source.malformed(e.to_string()))?;
    }
    Ok(volume)
}
