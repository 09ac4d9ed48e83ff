//! Volume files.

mod decompress;
mod source;

mod raw;

use crate::Result;
use fovol_core::{Dtype, Endian, Volume};
pub use source::Source;
use std::path::Path;

/// What a user says about a volume over the head of its file.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Overrides {
    /// Voxels along x, y, z.
    pub dims: Option<[usize; 3]>,
    /// The type of one component.
    pub dtype: Option<Dtype>,
    /// The byte order.
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
    let source = Source::open(path)?;
    let volume = raw::parse(&source, overrides)?;
    finished(&source, volume, overrides)
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
