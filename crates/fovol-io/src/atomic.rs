//! Files that appear under their name only when they are complete.

use crate::{Error, Result};
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::Path;
use tempfile::{NamedTempFile, TempPath};

/// Writes `path` by `fill`: to a temporary name in the same folder, renamed when everything is written.
///
/// # Errors
/// What `fill` or the system said; nothing is left under either name then.
pub fn write(path: &Path, fill: impl FnOnce(&mut BufWriter<&File>) -> io::Result<()>) -> Result<()> {
    let failed = |source| Error::io("write", path, source);
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let temporary = NamedTempFile::with_prefix_in(".fovolnet-", folder).map_err(failed)?;
    {
        let mut out = BufWriter::with_capacity(1 << 18, temporary.as_file());
        fill(&mut out).and_then(|()| out.flush()).map_err(failed)?;
    }
    persist(temporary.into_temp_path(), path)
}

/// Gives a complete temporary file its name.
///
/// # Errors
/// What the system said; the temporary file is gone then.
pub fn persist(temporary: TempPath, path: &Path) -> Result<()> {
    readable_by_all(&temporary).map_err(|e| Error::io("write", path, e))?;
    temporary.persist(path).map_err(|e| Error::io("write", path, e.error))
}

/// Writes `bytes` to `path` as [`write()`] does.
///
/// # Errors
/// As [`write()`].
pub fn write_bytes(path: &Path, bytes: &[u8]) -> Result<()> {
    write(path, |out| out.write_all(bytes))
}

/// Makes the folder `path` and those above it.
///
/// # Errors
/// What the system said.
pub fn make_folder(path: &Path) -> Result<()> {
    fs::create_dir_all(path).map_err(|source| Error::io("make the folder", path, source))
}

/// Temporary files are private; results are as other new files.
#[cfg(unix)]
fn readable_by_all(file: &Path) -> io::Result<()> {
    use std::os::unix::fs::PermissionsExt;
    fs::set_permissions(file, fs::Permissions::from_mode(0o644))
}

#[cfg(not(unix))]
fn readable_by_all(_: &Path) -> io::Result<()> {
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failure_leaves_nothing_and_keeps_what_was_there() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.bin");
        write_bytes(&path, b"old").unwrap();
        let full = write(&path, |out| {
            out.write_all(b"half of the new")?;
            Err(io::ErrorKind::StorageFull.into())
        });
        assert!(full.unwrap_err().to_string().contains("free some space"));
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_missing_folder_is_named() {
        let error = write_bytes(Path::new("/no/such/folder/x"), b"").unwrap_err().to_string();
        assert!(error.contains("/no/such/folder/x") && error.contains("check the path"), "{error}");
    }
}
