//! Files that nothing is written over: those that are looked at.

use fovolnet::core::input;
use fovolnet::io::{Result, atomic};
use std::path::Path;

/// Refuses to write over the file `path` if this viewer has read it, as the volume that is open; but what `is_alike` says holds
/// the same kind of thing, as a session where one is to be saved, may be replaced.
///
/// # Errors
/// Such a file.
pub fn check(path: &Path, is_alike: impl FnOnce(&Path) -> bool) -> Result<()> {
    // To look whether it is alike is to read it.
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
