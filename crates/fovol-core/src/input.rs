//! Files that are read: what is no file is refused at once, and which files were read is known afterwards.
//!
//! Opening a pipe may wait for ever, and a device such as `/dev/zero` never ends. So whatever a path option names is opened here.
//! What a program has read it must not overwrite by mistake: [`contains`] knows it, through links too.

use std::collections::HashSet;
use std::fs::{self, File, Metadata};
use std::io::{self, Read};
use std::path::Path;
use std::sync::{LazyLock, Mutex, PoisonError};

/// Opens the file at `path` to read it.
///
/// # Errors
/// A folder, a pipe or a device; what the system said.
pub fn open(path: &Path) -> io::Result<File> {
    let found = fs::metadata(path)?;
    check(&found)?;
    let file = File::open(path)?;
    remember(path, &found);
    Ok(file)
}

/// All bytes of the file at `path`.
///
/// # Errors
/// As [`open`].
pub fn read(path: &Path) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    open(path)?.read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// The text of the file at `path`.
///
/// # Errors
/// As [`open`]; bytes that are no UTF-8.
pub fn read_to_string(path: &Path) -> io::Result<String> {
    let mut text = String::new();
    open(path)?.read_to_string(&mut text)?;
    Ok(text)
}

/// Says that the file at `path`, if there is one, will be read.
pub fn add(path: &Path) {
    if let Ok(found) = fs::metadata(path) {
        remember(path, &found);
    }
}

/// Whether `path` leads to a file that was opened here, by whatever name.
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

/// What tells a file from all others, whatever its name: a device and a number on it, which a file that is made later may have when
/// this one is gone, and when it was made, where the system knows that.
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

/// The files that were read. As many as there are different ones, however often each is opened.
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
            // Times of files have steps of some milliseconds.
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
