//! Outputs that are not regular files: pipes, terminals, `/dev/null`.

use crate::{Error, Result};
use std::fs::{self, File};
use std::io;
use std::path::Path;

/// Whether `path` exists and is neither a file nor a folder, but a device or a pipe.
///
/// Such a path must not be replaced by a new file: for an administrator, that would remove the device for everybody.
pub(crate) fn is_stream(path: &Path) -> bool {
    fs::metadata(path).is_ok_and(|found| !found.is_file() && !found.is_dir())
}

/// Opens a pipe or a device for writing.
///
/// # Errors
/// A pipe without a reader, a block device; errors of the operating system.
pub(crate) fn open_stream(path: &Path) -> Result<File> {
    open(path).map_err(|e| Error::io("write", path, e))
}

#[cfg(not(unix))]
fn open(path: &Path) -> io::Result<File> {
    File::options().write(true).open(path)
}

/// How long somebody has to begin to read a pipe.
#[cfg(unix)]
const PATIENCE: std::time::Duration = std::time::Duration::from_millis(700);

#[cfg(unix)]
fn open(path: &Path) -> io::Result<File> {
    use std::os::unix::fs::{FileTypeExt, OpenOptionsExt};
    let kind = fs::metadata(path)?.file_type();
    if kind.is_block_device() {
        let problem = "it is a disk, and writing into it would destroy what it holds; name a file";
        return Err(io::Error::new(io::ErrorKind::InvalidInput, problem));
    }
    let mut options = File::options();
    options.write(true);
    if !kind.is_fifo() {
        return options.open(path);
    }
    // Without this flag the system waits for a reader, for ever if need be.
    let mut probe = options.clone();
    probe.custom_flags(libc::O_NONBLOCK);
    let started = std::time::Instant::now();
    loop {
        match probe.open(path) {
            // The first one is closed last, or the reader takes it for the end.
            Ok(_reader_is_there) => return options.open(path),
            Err(e) if e.raw_os_error() != Some(libc::ENXIO) => return Err(e),
            Err(_) if started.elapsed() > PATIENCE => {
                let problem = "nobody reads this pipe; start the program that reads it first";
                return Err(io::Error::other(problem));
            }
            Err(_) => std::thread::sleep(std::time::Duration::from_millis(10)),
        }
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use crate::atomic::{persist, temporary, write_bytes};
    use std::io::Write;

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
                let (mut file, whole) = temporary(&pipe).unwrap();
                file.write_all(b"frames").unwrap();
                persist(whole, &pipe).unwrap();
            } else {
                write_bytes(&pipe, b"frames").unwrap();
            }
            assert_eq!(reader.join().unwrap(), b"frames");
            assert!(fs::metadata(&pipe).unwrap().file_type().is_fifo());
        }
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_pipe_without_a_reader_is_an_error_within_a_second() {
        let folder = tempfile::tempdir().unwrap();
        let pipe = folder.path().join("pipe");
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        let started = std::time::Instant::now();
        let error = write_bytes(&pipe, b"nothing").unwrap_err().to_string();
        assert!(error.contains("nobody reads"), "{error}");
        assert!(started.elapsed().as_secs_f64() < 1.0);
    }
}
