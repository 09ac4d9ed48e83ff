//! Protection of opened files from being overwritten.

use fovolnet::core::input;
use fovolnet::io::{Result, atomic};
use std::path::Path;

/// Checks that writing to `path` overwrites no file that this viewer has read, such as the open volume. Files for
/// which `is_alike` returns true may be replaced, for example a session by a session.
///
/// # Errors
/// The file was read and is of another kind.
pub fn check(path: &Path, is_alike: impl FnOnce(&Path) -> bool) -> Result<()> {
    // `is_alike` reads the file, so `contains` must come first.
    if input::contains(path) && !is_alike(path) { atomic::refuse_input(path) } else { Ok(()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_read_is_replaced_by_its_like_alone() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("volume.nrrd");
        std::fs::write(&path, "voxels").unwrap();
        check(&path, |_| false).unwrap();
        input::open(&path).unwrap();
        check(&path, |_| true).unwrap();
        let error = check(&path, |_| false).unwrap_err().to_string();
        assert!(error.contains("volume.nrrd"), "{error}");
    }
}
