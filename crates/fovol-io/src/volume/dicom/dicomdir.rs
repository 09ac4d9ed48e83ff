//! Directories of files on a medium (PS3.3, annex F): DICOMDIR.

use super::file::DicomFile;
use super::tags;
use crate::Result;
use crate::volume::Source;
use std::path::{Path, PathBuf};

/// The files that the directory in `source` lists, in its folder or deeper.
///
/// # Errors
/// A directory that lists none.
pub fn files(source: &Source) -> Result<Vec<PathBuf>> {
    let file = DicomFile::open(source)?;
    let records = file.data_set().items(tags::DIRECTORY_RECORDS);
    let folder = source.path().parent().unwrap_or(Path::new(""));
    let named = records.iter().filter_map(|record| record.text(tags::REFERENCED_FILE));
    let files: Vec<PathBuf> = named.filter_map(|name| path_of(folder, &name)).collect();
    if files.is_empty() {
        return Err(source.malformed("it lists no files; name the folder that holds them"));
    }
    Ok(files)
}

/// The path of a file whose folders and name are parts of `name`, in the case that it has on the disk.
fn path_of(folder: &Path, name: &str) -> Option<PathBuf> {
    let parts: Vec<&str> = name.split('\\').map(str::trim).collect();
    // Nothing outside the medium is read.
    let is_plain =
        |part: &&str| !part.is_empty() && *part != ".." && *part != "." && !part.contains(['/', '\0']);
    if !parts.iter().all(is_plain) {
        return None;
    }
    let joined = |parts: &[String]| parts.iter().fold(folder.to_owned(), |path, part| path.join(part));
    let upper: Vec<String> = parts.iter().map(|&part| part.to_owned()).collect();
    let lower: Vec<String> = parts.iter().map(|part| part.to_lowercase()).collect();
    Some([joined(&upper), joined(&lower)].into_iter().find(|path| path.is_file()).unwrap_or(joined(&upper)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_outside_is_named() {
        assert_eq!(path_of(Path::new("a"), "IMG\\1"), Some("a/IMG/1".into()));
        for name in ["..\\x", "/etc/x", "a\\\\b", "."] {
            assert_eq!(path_of(Path::new("a"), name), None, "{name}");
        }
    }
}
