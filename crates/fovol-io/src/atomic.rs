//! Atomic writes: a file appears under its name only when it is complete and on the disk.
//!
//! Symbolic links stay links. Devices and pipes, such as `/dev/null`, are written in place. Temporary files are
//! registered in [`fovol_core::unfinished`], so that a signal leaves none of them behind.

use crate::stream::{is_stream, open_stream};
use crate::{Error, Result};
use fovol_core::input;
use fovol_core::unfinished::{self, Gate};
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use tempfile::TempPath;

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

/// Writes `path` with `fill`: to a temporary file in the same folder, renamed when it is complete.
///
/// # Errors
/// Errors of `fill` or of the operating system; then neither the file nor its temporary file remains.
pub fn write(path: &Path, fill: impl FnOnce(&mut Output<'_>) -> io::Result<()>) -> Result<()> {
    prepare(path, fill)?.complete()
}

/// The writer that [`write()`] hands to its closure.
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

/// A complete file without its final name. It is removed unless [`Self::complete`] is called.
#[must_use]
pub struct Prepared {
    path: PathBuf,
    /// None if `path` is a device or a pipe, which was written in place.
    temporary: Option<Temporary>,
}

/// The name of a temporary file, which is removed with this.
#[derive(Debug)]
pub struct Temporary {
    /// Dropped first: what is entered may be gone already, what is there must be entered.
    path: TempPath,
    _entry: Entry,
}

impl Temporary {
    /// The path of the temporary file.
    pub fn path(&self) -> &Path {
        &self.path
    }
}

/// A file that is entered in [`unfinished`].
#[derive(Debug)]
struct Entry(PathBuf);

impl Drop for Entry {
    fn drop(&mut self) {
        unfinished::forget_file(&self.0);
    }
}

impl Prepared {
    /// Gives the file its name.
    ///
    /// # Errors
    /// Errors of the operating system; the file is removed then.
    pub fn complete(self) -> Result<()> {
        self.complete_within(&Gate::enter())
    }

    /// Gives this file its name, then `next`, which refers to this file, once this one is on the disk.
    ///
    /// A signal finds both files or neither.
    ///
    /// # Errors
    /// Those of [`Self::complete`].
    pub fn complete_before(self, next: Self) -> Result<()> {
        let path = target(&self.path);
        let gate = Gate::enter();
        self.complete_within(&gate)?;
        sync_folder(&path);
        next.complete_within(&gate)
    }

    fn complete_within(self, gate: &Gate) -> Result<()> {
        match self.temporary {
            Some(temporary) => name(temporary, &self.path, gate),
            None => Ok(()),
        }
    }
}

/// Writes the content of `path` with `fill`, but does not give the file its name yet.
///
/// Files that belong together can then appear together.
///
/// # Errors
/// Those of [`write()`].
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
    let (file, temporary) = temporary(path)?;
    filled(&file)?;
    file.sync_all().map_err(failed)?;
    Ok(Prepared { path: path.to_owned(), temporary: Some(temporary) })
}

/// Creates a temporary file with the extension of `path`.
///
/// It lies in the folder of `path`, or in the system's temporary folder if `path` is a device or a pipe.
///
/// # Errors
/// Errors of the operating system.
pub fn temporary(path: &Path) -> Result<(File, Temporary)> {
    keep_input(path)?;
    // The system says so too, but only when all is written and a second file may have its name already.
    if path.is_dir() {
        return Err(Error::io("write", path, io::ErrorKind::IsADirectory.into()));
    }
    let extension = path.extension().map(|e| format!(".{}", e.display())).unwrap_or_default();
    let mut builder = tempfile::Builder::new();
    builder.prefix(".fovolnet-").suffix(&extension);
    let target = (!is_stream(path)).then(|| target(path));
    let gate = Gate::enter();
    let made = match &target {
        Some(target) => builder.tempfile_in(folder_of(target)),
        None => builder.tempfile(),
    };
    let (file, path) = made.map_err(|e| Error::io("write", path, e))?.into_parts();
    gate.add_file(&path);
    let entry = Entry(path.to_path_buf());
    Ok((file, Temporary { path, _entry: entry }))
}

/// Gives a complete [`temporary`] file its name, once it is on the disk.
///
/// # Errors
/// Errors of the operating system; the temporary file is removed then.
pub fn persist(temporary: Temporary, path: &Path) -> Result<()> {
    let failed = |e| Error::io("write", path, e);
    if is_stream(path) {
        let mut complete = File::open(temporary.path()).map_err(failed)?;
        return io::copy(&mut complete, &mut open_stream(path)?).map(drop).map_err(failed);
    }
    // Some systems sync what was opened to be written alone. It is the whole file that is synced, whoever wrote it.
    let file = File::options().write(true).open(temporary.path());
    file.and_then(|file| file.sync_all()).map_err(failed)?;
    name(temporary, path, &Gate::enter())
}

/// Renames the file `temporary`, which is on the disk, to `path`; nobody else renames any meanwhile.
fn name(temporary: Temporary, path: &Path, _gate: &Gate) -> Result<()> {
    let failed = |e| Error::io("write", path, e);
    keep_input(path)?;
    readable_by_all(temporary.path()).map_err(failed)?;
    temporary.path.persist(target(path)).map_err(|e| failed(e.error))
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
/// Those of [`write()`].
pub fn write_bytes(path: &Path, bytes: &[u8]) -> Result<()> {
    write(path, |out| out.write_all(bytes))
}

/// Makes the folder `path` and those above it.
///
/// # Errors
/// Errors of the operating system.
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
        let (_file, temporary) = temporary(&folder.path().join("clip.mp4")).unwrap();
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
