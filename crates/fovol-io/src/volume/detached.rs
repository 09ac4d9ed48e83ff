//! Writes voxels to a file of their own, beside their header.

use super::voxels::Voxels;
use crate::{Error, Result, atomic};
use std::fs::File;
use std::io::{Read, Write};
use std::path::Path;

/// Files beside the named output that may be overwritten.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Beside {
    /// Only files that were written for the named file.
    #[default]
    Own,
    /// Any file.
    All,
}

/// Writes `voxels` to `x.raw` beside the header `x.nhdr` or `x.mhd`.
///
/// `text` maps the name `x.raw` to the text of the header. Both files are complete before either gets its name, and the
/// header gets its name last.
///
/// # Errors
/// A name that text headers cannot hold; an existing file that was not written for this header, unless `beside` permits
/// overwriting it; errors of the operating system.
pub fn write(
    voxels: &Voxels<'_>,
    header: &Path,
    beside: Beside,
    text: impl FnOnce(&str) -> String,
) -> Result<()> {
    let path = header.with_extension("raw");
    let name = path.file_name().and_then(|name| name.to_str());
    // Headers are lines, and `%` makes patterns of them.
    let name =
        name.filter(|name| !name.contains(['\n', '\r', '%']) && name.trim() == *name).ok_or_else(|| {
            Error::unsupported(header, "such a name cannot stand in a header; use letters, digits, - and _")
        })?;
    atomic::keep_input(&path)?;
    if beside == Beside::Own && path.exists() && !was_written_for(header, name) {
        return Err(Error::InTheWay { path, main: header.to_owned() });
    }
    let voxels = atomic::prepare(&path, |out| voxels.write_to(out))?;
    let header = atomic::prepare(header, |out| out.write_all(text(name).as_bytes()))?;
    voxels.complete_before(header)
}

/// Extensions of headers whose voxels are in a separate file.
const HEADERS: [&str; 2] = ["nhdr", "mhd"];

/// Whether the header at `header`, and no other header beside it, refers to the data file `name`.
fn was_written_for(header: &Path, name: &str) -> bool {
    let own = header.extension().unwrap_or_default();
    let mut others = HEADERS.iter().filter(|ending| !own.eq_ignore_ascii_case(ending));
    names(header, name) && !others.any(|ending| names(&header.with_extension(ending), name))
}

/// Headers are short; voxels may follow them.
const LONGEST_HEADER: u64 = 1 << 20;

/// Whether `path` is a header that names `name` as its data file.
fn names(path: &Path, name: &str) -> bool {
    let mut bytes = Vec::new();
    let file = if path.is_file() { File::open(path).ok() } else { None };
    let read = file.and_then(|file| file.take(LONGEST_HEADER).read_to_end(&mut bytes).ok());
    let text = String::from_utf8_lossy(&bytes);
    read.is_some()
        && text.lines().filter_map(|line| line.split_once([':', '='])).any(|(key, value)| {
            let key = key.to_ascii_lowercase().replace(' ', "");
            ["datafile", "elementdatafile"].contains(&&*key) && value.trim() == name
        })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fault;
    use crate::volume::{write, write_with};
    use fovol_core::{Grid, Volume};
    use std::fs;

    fn volume(value: u16) -> Volume {
        Volume::from_values(Grid::new([3, 2, 1], [1.0; 3]).unwrap(), vec![value; 6]).unwrap()
    }

    #[test]
    fn only_what_was_written_for_a_header_is_replaced() {
        for (ending, other) in [("nhdr", "mhd"), ("mhd", "nhdr")] {
            let folder = tempfile::tempdir().unwrap();
            let [header, twin, raw] =
                [ending, other, "raw"].map(|ending| folder.path().join("scan").with_extension(ending));
            fs::write(&raw, "of somebody else").unwrap();
            for text in ["", "data file: other.raw\nscan.raw\n", "ElementDataFile = LOCAL\n"] {
                fs::write(&header, text).unwrap();
                let error = write(&volume(1), &header).unwrap_err().to_string();
                assert!(error.contains("scan.raw") && error.contains("--overwrite"), "{error}");
                assert_eq!(fs::read(&raw).unwrap(), b"of somebody else");
                assert_eq!(fs::read_to_string(&header).unwrap(), text);
            }
            write_with(&volume(1), &header, Beside::All).unwrap();
            // From now on it is this header's own.
            write(&volume(2), &header).unwrap();
            assert_eq!(fs::read(&raw).unwrap(), [2u16; 6].map(u16::to_le_bytes).concat());
            let error = write(&volume(3), &twin).unwrap_err().to_string();
            assert!(error.contains("scan.raw"), "{error}");
            write_with(&volume(3), &twin, Beside::All).unwrap();
            // Both headers have it.
            assert!(write(&volume(4), &header).is_err());
        }
    }

    #[test]
    fn both_files_appear_or_none() {
        for (ending, all) in [("nhdr", 12 + 120), ("mhd", 12 + 150)] {
            let folder = tempfile::tempdir().unwrap();
            let header = folder.path().join("scan").with_extension(ending);
            for room in 0..all {
                fault::after(room, || write(&volume(1), &header)).unwrap_err();
                assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0, "{ending} {room}");
            }
            fs::create_dir(&header).unwrap();
            write(&volume(1), &header).unwrap_err();
            assert!(!header.with_extension("raw").exists(), "{ending}");
            fs::remove_dir(&header).unwrap();
            write(&volume(1), &header).unwrap();
            let old = ["raw", ending].map(|ending| fs::read(header.with_extension(ending)).unwrap());
            for room in 0..all {
                fault::after(room, || write(&volume(2), &header)).unwrap_err();
                let kept = ["raw", ending].map(|ending| fs::read(header.with_extension(ending)).unwrap());
                assert_eq!(kept, old, "{ending} {room}");
            }
        }
    }
}
