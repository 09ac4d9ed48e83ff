//! Files that appear under their name only when they are complete.
//!
//! A link to a file stays a link. What is no file, `/dev/null` or a pipe, keeps its name and is written into.

use crate::{Error, Result};
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use tempfile::{NamedTempFile, TempPath};

/// Writes `path` by `fill`: to a temporary name in the same folder, renamed when everything is written.
///
/// # Errors
/// What `fill` or the system said; nothing is left under either name then.
pub fn write(path: &Path, fill: impl FnOnce(&mut BufWriter<&File>) -> io::Result<()>) -> Result<()> {
    let filled = |file: &File| {
        let mut out = BufWriter::with_capacity(1 << 18, file);
        fill(&mut out).and_then(|()| out.flush()).map_err(|e| Error::io("write", path, e))
    };
    if is_stream(path) {
        return filled(&open_stream(path)?);
    }
    let temporary = temporary(path)?;
    filled(temporary.as_file())?;
    persist(temporary.into_temp_path(), path)
}

/// A temporary file for what is to be `path`, with its extension: in the folder where that will be, or among the system's
/// temporary files if `path` is no file.
///
/// # Errors
/// What the system said.
pub fn temporary(path: &Path) -> Result<NamedTempFile> {
    let extension = path.extension().map(|e| format!(".{}", e.display())).unwrap_or_default();
    let mut builder = tempfile::Builder::new();
    builder.prefix(".fovolnet-").suffix(&extension);
    let made = if is_stream(path) {
        builder.tempfile()
    } else {
        let target = target(path);
        builder.tempfile_in(target.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new(".")))
    };
    made.map_err(|e| Error::io("write", path, e))
}

/// Gives a complete [`temporary`] file its name.
///
/// # Errors
/// What the system said; the temporary file is gone then.
pub fn persist(temporary: TempPath, path: &Path) -> Result<()> {
    let failed = |e| Error::io("write", path, e);
    if is_stream(path) {
        let mut complete = File::open(&temporary).map_err(failed)?;
        return io::copy(&mut complete, &mut open_stream(path)?).map(drop).map_err(failed);
    }
    readable_by_all(&temporary).map_err(failed)?;
    temporary.persist(target(path)).map_err(|e| failed(e.error))
}

/// Whether `path` is there and neither a file nor a folder: a device, a pipe. A new file in its place would take it from
/// everybody else, which the system lets its administrator do.
fn is_stream(path: &Path) -> bool {
    fs::metadata(path).is_ok_and(|found| !found.is_file() && !found.is_dir())
}

fn open_stream(path: &Path) -> Result<File> {
    File::options().write(true).open(path).map_err(|e| Error::io("write", path, e))
}

/// The file that `path` names, at the end of all links.
fn target(path: &Path) -> PathBuf {
    fs::canonicalize(path).unwrap_or_else(|_| path.into())
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
    fn an_ending_stays_with_the_temporary_file() {
        let folder = tempfile::tempdir().unwrap();
        let temporary = temporary(&folder.path().join("clip.mp4")).unwrap();
        assert_eq!(temporary.path().extension().unwrap(), "mp4");
        assert_eq!(temporary.path().parent().unwrap(), folder.path());
    }

    #[cfg(unix)]
    #[test]
    fn links_stay_links() {
        let folder = tempfile::tempdir().unwrap();
        let elsewhere = tempfile::tempdir().unwrap();
        let (file, link) = (elsewhere.path().join("out.bin"), folder.path().join("link.bin"));
        fs::write(&file, b"old").unwrap();
        std::os::unix::fs::symlink(&file, &link).unwrap();
        write_bytes(&link, b"new").unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read(&file).unwrap(), b"new");
    }

    #[cfg(unix)]
    #[test]
    fn devices_and_pipes_are_written_into() {
        use std::os::unix::fs::FileTypeExt;
        write_bytes(Path::new("/dev/null"), b"nothing").unwrap();
        assert!(fs::metadata("/dev/null").unwrap().file_type().is_char_device());

        let folder = tempfile::tempdir().unwrap();
        let pipe = folder.path().join("pipe.y4m");
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        for persisted in [false, true] {
            let reader = std::thread::spawn({
                let pipe = pipe.clone();
                move || fs::read(pipe).unwrap()
            });
            if persisted {
                let mut whole = temporary(&pipe).unwrap();
                whole.write_all(b"frames").unwrap();
                persist(whole.into_temp_path(), &pipe).unwrap();
            } else {
                write_bytes(&pipe, b"frames").unwrap();
            }
            assert_eq!(reader.join().unwrap(), b"frames");
            assert!(fs::metadata(&pipe).unwrap().file_type().is_fifo());
        }
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_missing_folder_is_named() {
        let error = write_bytes(Path::new("/no/such/folder/x"), b"").unwrap_err().to_string();
        assert!(error.contains("/no/such/folder/x") && error.contains("check the path"), "{error}");
    }
}
