//! DICOM: series of one picture a file, files of many frames, and segmentations.
//!
//! The reader knows about a hundred attributes and passes over all others, so nothing that says who somebody is gets
//! into memory, notes or errors.

mod arrange;
mod assemble;
mod codec;
mod colours;
mod data_set;
mod dicomdir;
mod elements;
mod file;
mod frames;
mod functional_groups;
mod header;
mod pixel_format;
mod plane;
mod plane_attributes;
mod repeats;
mod resample;
mod samples;
mod search;
mod segmentation;
mod segments;
mod series;
mod stack;
mod stacks;
mod suv;
mod syntax;
mod tags;
mod text;
mod values;

use super::{Overrides, Source};
use crate::{Error, Result};
use assemble::Files;
use file::DicomFile;
use fovol_core::Volume;
use header::Header;
use pixel_format::Photometric;
use search::Found;
pub use series::Series;
use series::{Candidate, candidates, listed, select};
use std::path::Path;
use suv::Suv;

/// Reads the DICOM file in `source`: its frames, or a series of the files that a DICOMDIR lists.
///
/// # Errors
/// Damaged files, files without pictures, and kinds that are not read.
pub fn parse(source: &Source, overrides: &Overrides) -> Result<Volume> {
    if DicomFile::open(source)?.is_directory {
        return chosen(source, &search::in_directory(source)?, overrides);
    }
    let header = Header::read(source)?.ok_or_else(|| source.unsupported(NO_PICTURES))?;
    let beside = companions(source, &header);
    let found = Found { headers: vec![header], notes: Vec::new() };
    let volume = chosen(source, &found, overrides)?;
    Ok(match beside {
        0 => volume,
        count => volume.with_note(format!(
            "is one of {} files of its series in this folder; name the folder to read all of them",
            count + 1
        )),
    })
}

/// Advice for files of DICOM that are no volumes.
const NO_PICTURES: &str =
    "it is a DICOM file without pictures; name a file or folder of CT, MR, PET or the like";

/// Reads a series from the files in the folder `path` and the folders in it; none if it holds no DICOM.
///
/// # Errors
/// Damaged files, and kinds that are not read.
pub fn parse_folder(path: &Path, overrides: &Overrides) -> Result<Option<Volume>> {
    let found = search::in_folder(path)?;
    if found.headers.is_empty() {
        return Ok(None);
    }
    chosen(&Source::from_bytes(path, Vec::new()), &found, overrides).map(Some)
}

/// Whether a file right in the folder `path` is of DICOM.
pub fn is_in_folder(path: &Path) -> bool {
    /// Series lie in folders of their own.
    const LOOKED_AT: usize = 16;
    let entries = std::fs::read_dir(path).into_iter().flatten().flatten();
    let mut files = entries.map(|entry| entry.path()).filter(|path| path.is_file()).take(LOOKED_AT);
    files.any(|file| search::is_dicom(&file))
}

/// Lists the volumes of the file, DICOMDIR or folder at `path`, in the order in which `--series` counts them from 1 on.
///
/// # Errors
/// Files that cannot be read, or of other kinds.
pub fn series(path: &Path) -> Result<Vec<Series>> {
    let found = match path.is_dir() {
        true => search::in_folder(path)?,
        false => {
            let source = Source::open(path)?;
            match DicomFile::open(&source)?.is_directory {
                true => search::in_directory(&source)?,
                false => Found { headers: Header::read(&source)?.into_iter().collect(), notes: Vec::new() },
            }
        }
    };
    Ok(candidates(&found.headers).into_iter().map(|candidate| candidate.series).collect())
}

/// The number of other files of the series of `header` in the folder of `source`.
fn companions(source: &Source, header: &Header) -> usize {
    if header.planes.len() > 1 || header.segments.is_some() || !source.path().is_file() {
        return 0;
    }
    let is_other = |other: &&Header| other.series == header.series && other.instance != header.instance;
    search::beside(source.path()).headers.iter().filter(is_other).count()
}

/// The series of `found` that is wanted.
fn chosen(source: &Source, found: &Found, overrides: &Overrides) -> Result<Volume> {
    let candidates = candidates(&found.headers);
    if candidates.is_empty() {
        return Err(Error::unsupported(source.path(), NO_PICTURES));
    }
    let number = select(&candidates, overrides.series.as_deref()).map_err(|e| source.malformed(e))?;
    let files = Files { source, headers: &found.headers };
    let Candidate { stack, .. } = &candidates[number];
    let header = &found.headers[stack.first().file];
    let mut volume = match &header.segments {
        Some(segments) => segmentation::volume(&files, segments, &stack.times[0])?,
        None => assemble::volume(&files, &stack.times, overrides)?,
    };
    if candidates.len() > 1 && overrides.series.is_none() {
        let plural = if candidates.len() == 2 { "volume" } else { "volumes" };
        volume = volume.with_note(format!(
            "has {} other {plural} ({}); number {} is shown; --series chooses another",
            candidates.len() - 1,
            listed(&candidates, Some(number)),
            number + 1
        ));
    }
    let notes = found.notes.iter().chain(&stack.notes).cloned().chain(remarks(header));
    Ok(notes.fold(volume, Volume::with_note))
}

/// What is to be known of the values.
fn remarks(header: &Header) -> Vec<String> {
    let mut notes = Vec::new();
    if header.format.photometric == Photometric::InvertedGrey {
        notes.push("says that zero is white; values are shown as they are stored".into());
    }
    if let Some(padding) = header.padding {
        notes.push(format!("says that the stored number {padding} stands for no data; it is shown as data"));
    }
    match header.suv {
        Some(Suv::Factor(factor)) => {
            notes.push(format!("its values are Bq/ml; SUVbw = value × {factor:.6e}"));
        }
        Some(Suv::Applied) => notes.push("its values are SUVbw".into()),
        None => {}
    }
    notes
}

#[cfg(test)]
mod tests;
