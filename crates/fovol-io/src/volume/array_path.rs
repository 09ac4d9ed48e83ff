//! Names such as `FILE.h5:/path/to/dataset`: a file and an array in it; and addresses of the web.

use std::path::{Path, PathBuf};

/// Splits `FILE:ARRAY` into the file, or a folder of Zarr, and the name of the array. A path that exists, or of which no
/// part before a colon does, is left whole.
///
/// The colon after a drive letter never splits, and neither do colons in names of folders.
pub fn split_array(path: &Path) -> (PathBuf, Option<String>) {
    let whole = || (path.to_owned(), None);
    let Some(text) = path.to_str().filter(|text| text.contains(':') && !path.exists()) else {
        return whole();
    };
    let colons = text.match_indices(':').map(|(at, _)| at);
    let mut splits = colons.filter(|&at| !is_drive(text, at)).map(|at| (&text[..at], &text[at + 1..]));
    let holds_arrays = |file: &str| Path::new(file).is_file() || is_zarr(Path::new(file));
    match splits.find(|(file, array)| !array.is_empty() && holds_arrays(file)) {
        Some((file, array)) => (file.into(), Some(array.to_owned())),
        None => whole(),
    }
}

/// Whether `path` is an address of the web: it begins with `http://` or `https://`.
pub fn is_remote(path: &Path) -> bool {
    // Paths may lose a slash of two that follow each other.
    let text = path.to_string_lossy();
    ["http:/", "https:/"].iter().any(|scheme| text.starts_with(scheme))
}

/// Whether the folder `path` holds a group or an array of Zarr.
pub fn is_zarr(path: &Path) -> bool {
    [".zattrs", ".zgroup", ".zarray", "zarr.json"].iter().any(|file| path.join(file).is_file())
}

/// Whether the colon at `at` follows the letter of a drive.
fn is_drive(text: &str, at: usize) -> bool {
    at == 1
        && text.as_bytes()[0].is_ascii_alphabetic()
        && matches!(text.as_bytes().get(2), Some(b'\\' | b'/'))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrays_are_split_from_files_that_exist() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        for name in ["a.h5", "b:c.h5", "b"] {
            std::fs::write(at(name), "x").unwrap();
        }
        for (name, file, array) in [
            ("a.h5:/g/d", "a.h5", Some("/g/d")),
            ("a.h5:d:e", "a.h5", Some("d:e")),
            ("b:c.h5", "b:c.h5", None),
            ("gone.h5:/d", "gone.h5:/d", None),
            ("a.h5", "a.h5", None),
            ("a.h5:", "a.h5:", None),
        ] {
            assert_eq!(split_array(&at(name)), (at(file), array.map(str::to_owned)), "{name}");
        }
    }

    #[test]
    fn drives_are_no_files() {
        assert!(is_drive(r"C:\data.h5:/d", 1) && is_drive("c:/x", 1));
        assert!(!is_drive("c:x", 1) && !is_drive(r"C:\data.h5:/d", 10));
    }
}
