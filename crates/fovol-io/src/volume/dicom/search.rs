//! Files of a folder, and what they say of their pictures.

use super::file::is_marked;
use super::header::Header;
use super::{dicomdir, file::DicomFile};
use crate::volume::Source;
use crate::{Error, Result, natural_order};
use fovol_core::stop;
use rayon::prelude::*;
use std::io::Read;
use std::path::{Path, PathBuf};

/// Folders in folders are searched so deep.
const DEEPEST: usize = 8;

/// More files than this are a whole archive.
const MOST_FILES: usize = 100_000;

/// Headers that were found, and what is to be said of the search.
#[derive(Default)]
pub struct Found {
    /// Headers of files with pictures, by the names of the files.
    pub headers: Vec<Header>,
    /// What was left out.
    pub notes: Vec<String>,
}

/// The pictures of all files in `folder` and the folders in it.
///
/// # Errors
/// A folder that cannot be read; a file that is the only one and damaged.
pub fn in_folder(folder: &Path) -> Result<Found> {
    let mut files = Files { root: folder.canonicalize().ok(), ..Files::default() };
    files.add(folder, 0).map_err(|e| Error::io("read", folder, e))?;
    let mut found = headers(&files.names)?;
    if files.outside > 0 {
        found.notes.push(format!("{} links that lead out of the folder are not followed", files.outside));
    }
    if files.is_cut {
        found.notes.push(format!(
            "only {MOST_FILES} files down to {DEEPEST} folders are looked at; name a folder inside for others"
        ));
    }
    Ok(found)
}

/// The pictures of the files right beside `path`.
pub fn beside(path: &Path) -> Found {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut files = Files { root: folder.canonicalize().ok(), ..Files::default() };
    match files.add(folder, DEEPEST) {
        Ok(()) => headers(&files.names).unwrap_or_default(),
        Err(_) => Found::default(),
    }
}

/// The pictures of the files that the directory in `source` lists.
///
/// # Errors
/// A directory without files, or whose files are missing.
pub fn in_directory(source: &Source) -> Result<Found> {
    let files = dicomdir::files(source)?;
    let listed = files.len();
    let there: Vec<PathBuf> = files.into_iter().filter(|file| file.is_file()).collect();
    let missing = listed - there.len();
    if there.is_empty() {
        return Err(source.malformed(format!(
            "none of the {listed} files that it lists is there; copy the folders beside it too"
        )));
    }
    let mut found = headers(&there)?;
    if missing > 0 {
        found.notes.push(format!("{missing} of the {listed} files that it lists are missing"));
    }
    Ok(found)
}

/// Files of a folder.
#[derive(Default)]
struct Files {
    root: Option<PathBuf>,
    names: Vec<PathBuf>,
    outside: usize,
    is_cut: bool,
}

impl Files {
    fn add(&mut self, folder: &Path, depth: usize) -> std::io::Result<()> {
        stop::point();
        let mut entries = std::fs::read_dir(folder)?.collect::<std::io::Result<Vec<_>>>()?;
        entries.sort_by(|a, b| {
            natural_order::compare(&a.file_name().to_string_lossy(), &b.file_name().to_string_lossy())
        });
        for entry in entries {
            if self.names.len() >= MOST_FILES {
                self.is_cut = true;
                break;
            }
            let path = entry.path();
            if entry.file_name().to_string_lossy().starts_with('.') || self.leads_out(&entry, &path) {
                continue;
            }
            match path.is_dir() {
                false => self.names.push(path),
                true if depth < DEEPEST => {
                    // A folder inside that cannot be read hides no others.
                    let _ = self.add(&path, depth + 1);
                }
                true => self.is_cut = true,
            }
        }
        Ok(())
    }

    /// Whether the entry is a link to elsewhere, or to a folder, where links may lead in circles.
    fn leads_out(&mut self, entry: &std::fs::DirEntry, path: &Path) -> bool {
        if !entry.file_type().is_ok_and(|kind| kind.is_symlink()) {
            return false;
        }
        let target = path.canonicalize().ok().filter(|target| target.is_file());
        let is_inside =
            matches!((&target, &self.root), (Some(target), Some(root)) if target.starts_with(root));
        self.outside += usize::from(!is_inside);
        !is_inside
    }
}

/// The headers of `files`. Files of other kinds are left out.
fn headers(files: &[PathBuf]) -> Result<Found> {
    let read: Vec<Option<Result<Option<Header>>>> = files
        .par_iter()
        .map(|file| {
            stop::point();
            is_dicom(file).then(|| Source::open(file).and_then(|source| Header::read(&source)))
        })
        .collect();
    let mut found = Found::default();
    let mut damaged = Vec::new();
    for header in read.into_iter().flatten() {
        match header {
            Ok(Some(header)) => found.headers.push(header),
            // Reports, directories and presentations have no pictures.
            Ok(None) => {}
            Err(error) => damaged.push(error),
        }
    }
    match damaged.len() {
        0 => {}
        _ if found.headers.is_empty() => return Err(damaged.swap_remove(0)),
        1 => found.notes.push(format!("a file is left out: {}", damaged[0])),
        count => found.notes.push(format!("{count} files are left out; the first: {}", damaged[0])),
    }
    Ok(found)
}

/// Whether the start of the file at `path` looks like DICOM, with the mark or by its first elements.
pub fn is_dicom(path: &Path) -> bool {
    let mut start = Vec::new();
    let opened = std::fs::File::open(path);
    let is_read = opened.is_ok_and(|file| file.take(4096).read_to_end(&mut start).is_ok());
    is_read && (is_marked(&start) || begins_as_elements(path, start))
}

/// Whether `start` is that of elements without a preamble.
fn begins_as_elements(path: &Path, start: Vec<u8>) -> bool {
    matches!(start.as_slice(), [2 | 8, 0, _, 0, ..] | [0, 8, 0, _, ..])
        && DicomFile::open(&Source::from_bytes(path, start)).is_ok()
}
