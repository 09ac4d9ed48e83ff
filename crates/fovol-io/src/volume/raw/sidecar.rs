//! Sidecars: small files beside raw voxels that state their size and type.

use super::description::Description;
use super::{dat, json, xml};
use crate::Result;
use crate::volume::{Overrides, Source, metaimage, nrrd};
use fovol_core::Volume;
use std::path::{Path, PathBuf};

/// Voxels may follow a header; they are not searched for names.
const LONGEST_HEADER: usize = 1 << 20;

type Reader = fn(&Source) -> Result<Description>;

/// Metadata found beside a raw volume.
pub enum Found {
    /// No file describes the voxels.
    Nothing,
    /// A description.
    Description(Box<Description>),
    /// A header that is itself a volume file.
    Volume(Box<Volume>),
}

/// The reader of the sidecar `source`; none when it is none.
pub fn reader_of(source: &Source) -> Option<Reader> {
    match extension(source.path()).as_str() {
        "json" => Some(json::parse),
        "ivf" | "vvd" => Some(xml::parse),
        "dat" if dat::is_one(source) => Some(dat::parse),
        _ => None,
    }
}

/// Looks for a file that describes the voxels of `raw`.
///
/// # Errors
/// A damaged sidecar.
pub fn beside(raw: &Source, overrides: &Overrides) -> Result<Found> {
    for stem in stems(raw.path()) {
        // What this program wrote last comes first: it rewrites its own `.json`, nothing else.
        for ending in [".json", ".dat", ".ivf", ".vvd"] {
            let Some(sidecar) = open(&stem, ending)? else { continue };
            let Some(reader) = reader_of(&sidecar) else { continue };
            let said = match reader(&sidecar) {
                // Many programs put JSON of their own beside their files.
                Err(_) if ending == ".json" => continue,
                said => said?,
            };
            if speaks_of(&sidecar, &said, raw.path()) {
                return Ok(Found::Description(Box::new(said)));
            }
        }
        for ending in [".nhdr", ".mhd", ".nrrd", ".mha"] {
            let Some(header) = open(&stem, ending)? else { continue };
            let parser = if ending.starts_with(".n") { nrrd::parse } else { metaimage::parse };
            if names(&header, raw.path()) {
                return Ok(Found::Volume(Box::new(parser(&header, overrides)?)));
            }
        }
    }
    Ok(Found::Nothing)
}

/// `x` for `x.raw`; `x.raw` and `x` for `x.raw.gz`.
fn stems(raw: &Path) -> Vec<PathBuf> {
    let mut stems = vec![raw.with_extension("")];
    if extension(raw) == "gz" {
        stems.push(raw.with_extension("").with_extension(""));
    }
    stems
}

fn open(stem: &Path, ending: &str) -> Result<Option<Source>> {
    let mut path = stem.as_os_str().to_owned();
    path.push(ending);
    let path = PathBuf::from(path);
    if path.is_file() { Source::open(&path).map(Some) } else { Ok(None) }
}

/// Whether the text of `header` names the file `raw`.
fn names(header: &Source, raw: &Path) -> bool {
    let name = raw.file_name().unwrap_or_default().as_encoded_bytes();
    let text = &header.bytes()[..header.bytes().len().min(LONGEST_HEADER)];
    !name.is_empty() && text.windows(name.len()).any(|window| window == name)
}

/// Whether a sidecar means `raw`: it names it, or no file that is there (voxels are often renamed).
pub fn speaks_of(sidecar: &Source, said: &Description, raw: &Path) -> bool {
    said.file.as_deref().is_none_or(|file| {
        let named = sidecar.sibling_path(file);
        named.file_name() == raw.file_name() || !named.is_file()
    })
}

fn extension(path: &Path) -> String {
    path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase()
}
