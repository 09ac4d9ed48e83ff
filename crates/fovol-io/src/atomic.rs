//! Files that appear under their name only when they are complete, and on the disk.
//!
//! A link to a file stays a link. What is no file, `/dev/null` or a pipe, keeps its name and is written into.

use crate::stream::{is_stream, open_stream};
use crate::{Error, Result, temporaries};
use fovol_core::input;
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use tempfile::{NamedTempFile, TempPath};

/// Whether files that were read are kept.
static KEEPS_INPUTS: AtomicBool = AtomicBool::new(false);

/// Refuses from now on to replace a file that this program has read, see [`fovol_core::input`].
///
/// For programs that do one thing and end. Those that save what they have opened ask [`refuse_input`] where it matters.
pub fn keep_inputs() {
    KEEPS_INPUTS.store(true, Ordering::Relaxed);
}

/// Refuses `path` if it leads to a file that this program has read.
///
/// # Errors
/// Such a file.
pub fn refuse_input(path: &Path) -> Result<()> {
    if input::contains(path) { Err(Error::IsInput { path: path.to_owned() }) } else { Ok(()) }
}

/// Refuses `path` if it leads to a file that was read and is to be kept, see [`keep_inputs`].
pub(crate) fn keep_input(path: &Path) -> Result<()> {
    if KEEPS_INPUTS.load(Ordering::Relaxed) { refuse_input(path) } else { Ok(()) }
}

/// Writes `path` by `fill`: to a temporary name in the same folder, renamed when everything is written.
///
/// # Errors
/// What `fill` or the system said; nothing is left under either name then.
pub fn write(path: &Path, fill: impl FnOnce(&mut Output<'_>) -> io::Result<()>) -> Result<()> {
    prepare(path, fill)?.complete()
}

/// Where [`write()`] has what is written.
pub type Output<'a> = BufWriter<Sink<&'a File>>;

/// A file that is written to.
pub struct Sink<W>(pub(crate) W);

impl<W: Write> Write for Sink<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        #[cfg(test)]
        let bytes = &bytes[..crate::fault::room(bytes.len())?];
        self.0.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush()
    }
}

/// A complete file that has not got its name yet. Without [`Self::complete`] it is removed.
#[must_use]
pub struct Prepared {
    path: PathBuf,
    /// Nothing where `path` is no file: then it was written into.
    temporary: Option<TempPath>,
}

impl Prepared {
    /// Gives it its name.
    ///
    /// # Errors
    /// What the system said; the file is gone then.
    pub fn complete(self) -> Result<()> {
        match self.temporary {
            Some(temporary) => name(temporary, &self.path),
            None => Ok(()),
        }
    }

    /// Gives it its name, and `next`, which speaks of this file, its own when this one is on the disk.
    ///
    /// # Errors
    /// As [`Self::complete`].
    pub fn complete_before(self, next: Self) -> Result<()> {
        let path = target(&self.path);
        self.complete()?;
        sync_folder(&path);
        next.complete()
    }
}

/// Writes what is to be `path` by `fill`, without giving it that name: so that files which belong together appear together.
///
/// # Errors
/// As [`write()`].
pub fn prepare(path: &Path, fill: impl FnOnce(&mut Output<'_>) -> io::Result<()>) -> Result<Prepared> {
    let failed = |e| Error::io("write", path, e);
    let filled = |file: &File| {
        let mut out = BufWriter::with_capacity(1 << 18, Sink(file));
        fill(&mut out).and_then(|()| out.flush()).map_err(failed)
    };
    if is_stream(path) {
        filled(&open_stream(path)?)?;
        return Ok(Prepared { path: path.to_owned(), temporary: None });
    }
    let temporary = temporary(path)?;
    filled(temporary.as_file())?;
    temporary.as_file().sync_all().map_err(failed)?;
    Ok(Prepared { path: path.to_owned(), temporary: Some(temporary.into_temp_path()) })
}

/// A temporary file for what is to be `path`, with its extension: in the folder where that will be, or among the system's
/// temporary files if `path` is no file.
///
/// # Errors
/// What the system said.
pub fn temporary(path: &Path) -> Result<NamedTempFile> {
    keep_input(path)?;
    // The system says so too, but only when all is written and a second file may have its name already.
    if path.is_dir() {
        return Err(Error::io("write", path, io::ErrorKind::IsADirectory.into()));
    }
    let extension = path.extension().map(|e| format!(".{}", e.display())).unwrap_or_default();
    let mut builder = tempfile::Builder::new();
    builder.prefix(".fovolnet-").suffix(&extension);
    let made =
        if is_stream(path) { builder.tempfile() } else { builder.tempfile_in(folder_of(&target(path))) };
    let made = made.map_err(|e| Error::io("write", path, e))?;
    temporaries::add(made.path());
    Ok(made)
}

/// Gives a complete [`temporary`] file its name, once it is on the disk.
///
/// # Errors
/// What the system said; the temporary file is gone then.
pub fn persist(temporary: TempPath, path: &Path) -> Result<()> {
    let failed = |e| Error::io("write", path, e);
    if is_stream(path) {
        let mut complete = File::open(&temporary).map_err(failed)?;
        return io::copy(&mut complete, &mut open_stream(path)?).map(drop).map_err(failed);
    }
    // Some systems sync what was opened to be written alone. It is the whole file that is synced, whoever wrote it.
    File::options().write(true).open(&temporary).and_then(|file| file.sync_all()).map_err(failed)?;
    name(temporary, path)
}

/// Renames the file `temporary`, which is on the disk, to `path`.
fn name(temporary: TempPath, path: &Path) -> Result<()> {
    let failed = |e| Error::io("write", path, e);
    keep_input(path)?;
    readable_by_all(&temporary).map_err(failed)?;
    temporary.persist(target(path)).map_err(|e| failed(e.error))
}

/// Puts the names in the folder of `file` on the disk: two files that belong together are renamed in an order.
fn sync_folder(file: &Path) {
    if cfg!(unix) {
        // The file is there and complete; folders that cannot be synced, as of some networks, are none to despair of.
        let _ = File::open(folder_of(file)).and_then(|folder| folder.sync_all());
    }
}

fn folder_of(file: &Path) -> &Path {
    file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
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

    #[test]
    fn what_is_prepared_has_its_name_only_when_it_is_completed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.bin");
        let prepared = prepare(&path, |out| out.write_all(b"all")).unwrap();
        assert!(!path.exists());
        drop(prepared);
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
        prepare(&path, |out| out.write_all(b"all")).unwrap().complete().unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"all");
    }

    #[test]
    fn a_write_that_fails_at_any_byte_leaves_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.bin");
        for room in 0..10 {
            crate::fault::after(room, || write_bytes(&path, &[7; 10])).unwrap_err();
            assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0, "{room}");
        }
        crate::fault::after(10, || write_bytes(&path, &[7; 10])).unwrap();
        assert_eq!(fs::read(&path).unwrap(), [7; 10]);
    }

    #[test]
    fn inputs_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("in.bin");
        fs::write(&path, b"mine").unwrap();
        refuse_input(&path).unwrap();
        input::read(&path).unwrap();
        let error = refuse_input(&path).unwrap_err().to_string();
        assert!(error.contains("in.bin") && error.contains("another name"), "{error}");
    }

    #[test]
    fn a_missing_folder_is_named() {
        let error = write_bytes(Path::new("/no/such/folder/x"), b"").unwrap_err().to_string();
        assert!(error.contains("/no/such/folder/x") && error.contains("check the path"), "{error}");
    }
}
