//! Opening of input files. Only regular files are accepted, and every opened file is remembered.
//!
//! Opening a pipe may block for ever, and a device such as `/dev/zero` never ends. So every path that a user gives is
//! opened here. A program must not overwrite its own inputs by mistake; [`contains`] recognises them, also through
//! links.

use std::collections::HashSet;
use std::fs::{self, File, Metadata};
use std::io::{self, Read};
use std::path::Path;
use std::sync::{LazyLock, Mutex, PoisonError};

/// Opens the file at `path` for reading, and remembers it.
///
/// # Errors
/// A folder, a pipe or a device; errors of the operating system.
pub fn open(path: &Path) -> io::Result<File> {
    let found = fs::metadata(path)?;
    check(&found)?;
    let file = File::open(path)?;
    remember(path, &found);
    Ok(file)
}

/// Reads all bytes of the file at `path`.
///
/// # Errors
/// Errors of [`open`].
pub fn read(path: &Path) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    open(path)?.read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// Reads the text of the file at `path`.
///
/// # Errors
/// Errors of [`open`]; bytes that are not UTF-8.
pub fn read_to_string(path: &Path) -> io::Result<String> {
    let mut text = String::new();
    open(path)?.read_to_string(&mut text)?;
    Ok(text)
}

/// Remembers the file at `path`, if it exists, as an input that will be read.
pub fn add(path: &Path) {
    if let Ok(found) = fs::metadata(path) {
        remember(path, &found);
    }
}

/// Whether `path` leads to a file that was opened here, under any name.
pub fn contains(path: &Path) -> bool {
    let Ok(found) = fs::metadata(path) else { return false };
    identity(path, &found).is_some_and(|id| files().contains(&id))
}

fn check(found: &Metadata) -> io::Result<()> {
    let problem = match found {
        _ if found.is_file() => return Ok(()),
        _ if found.is_dir() => "it is a folder; name a file in it",
        _ => "it is a pipe or a device; save what comes from it to a file, and name that",
    };
    Err(io::Error::new(io::ErrorKind::InvalidInput, problem))
}

/// Identity of a file, independent of its name: device, inode number and, where known, the time of creation. A later
/// file may reuse the inode number of a deleted one.
#[cfg(unix)]
type Identity = (u64, u64, Option<std::time::SystemTime>);
#[cfg(not(unix))]
type Identity = std::path::PathBuf;

#[cfg(unix)]
fn identity(_: &Path, found: &Metadata) -> Option<Identity> {
    use std::os::unix::fs::MetadataExt;
    Some((found.dev(), found.ino(), found.created().ok()))
}

#[cfg(not(unix))]
fn identity(path: &Path, _: &Metadata) -> Option<Identity> {
    fs::canonicalize(path).ok()
}

/// All remembered files; each is stored once, however often it is opened.
fn files() -> std::sync::MutexGuard<'static, HashSet<Identity>> {
    static FILES: LazyLock<Mutex<HashSet<Identity>>> = LazyLock::new(Mutex::default);
    FILES.lock().unwrap_or_else(PoisonError::into_inner)
}

fn remember(path: &Path, found: &Metadata) {
    if let Some(id) = identity(path, found) {
        files().insert(id);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_are_no_files() {
        let folder = tempfile::tempdir().unwrap();
        let error = open(folder.path()).unwrap_err().to_string();
        assert!(error.contains("folder"), "{error}");
        assert_eq!(open(&folder.path().join("gone")).unwrap_err().kind(), io::ErrorKind::NotFound);
    }

    #[cfg(unix)]
    #[test]
    fn pipes_and_devices_are_refused_at_once() {
        let folder = tempfile::tempdir().unwrap();
        let pipe = folder.path().join("pipe");
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        for path in [&*pipe, Path::new("/dev/zero"), Path::new("/dev/null")] {
            for error in [read(path).unwrap_err(), read_to_string(path).unwrap_err()] {
                assert!(error.to_string().contains("pipe or a device"), "{}: {error}", path.display());
            }
        }
    }

    #[test]
    fn files_that_come_after_one_are_others() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file");
        for _ in 0..20 {
            fs::write(&path, "text").unwrap();
            if fs::metadata(&path).unwrap().created().is_err() {
                println!("skipped: nobody knows here when files were made");
                return;
            }
            assert!(!contains(&path));
            read(&path).unwrap();
            assert!(contains(&path));
            fs::remove_file(&path).unwrap();
            // File times have a resolution of some milliseconds.
            std::thread::sleep(std::time::Duration::from_millis(20));
        }
    }

    #[cfg(unix)]
    #[test]
    fn what_was_read_is_known_by_all_its_names() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("file"), "text").unwrap();
        fs::write(at("other"), "text").unwrap();
        std::os::unix::fs::symlink(at("file"), at("link")).unwrap();
        fs::hard_link(at("file"), at("twin")).unwrap();
        assert!(!contains(&at("file")));
        assert_eq!(read_to_string(&at("link")).unwrap(), "text");
        for name in ["file", "link", "twin", "./file"] {
            assert!(contains(&at(name)), "{name}");
        }
        assert!(!contains(&at("other")) && !contains(&at("gone")));
        add(&at("other"));
        assert!(contains(&at("other")));
    }
}
