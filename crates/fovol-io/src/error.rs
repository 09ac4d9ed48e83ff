use fovol_core::memory::Shortage;
use std::fmt::Display;
use std::io;
use std::path::{Path, PathBuf};

/// Errors of reading and writing files. Every message is one line: the problem, the place and the remedy.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The operating system refused.
    #[error("cannot {action} {}: {}{}", plain(path.display()), plain(source), advice(source))]
    Io {
        /// The attempted operation: "read", "write"…
        action: &'static str,
        /// The file or folder.
        path: PathBuf,
        /// The error of the operating system.
        source: io::Error,
    },
    /// The file is damaged or contradictory.
    #[error("{}: {}", plain(path.display()), plain(problem))]
    Malformed {
        /// The file.
        path: PathBuf,
        /// The damage, its place in the file, and the remedy.
        problem: String,
    },
    /// The file is valid, but its format or a feature of it is not supported.
    #[error("{}: {}", plain(path.display()), plain(problem))]
    Unsupported {
        /// The file.
        path: PathBuf,
        /// The unsupported feature, and an alternative.
        problem: String,
    },
    /// An output that is an input.
    #[error(
        "{} is read here, and writing it would destroy it; give the output another name",
        plain(path.display())
    )]
    IsInput {
        /// The file.
        path: PathBuf,
    },
    /// A file that nobody named would be replaced.
    #[error(
        "{} is there already, and was not written for {}; move it away, choose another name, or replace it with --overwrite",
        plain(path.display()),
        plain(main.display())
    )]
    InTheWay {
        /// The file that is there.
        path: PathBuf,
        /// The file that was to be written, of which it would be a part.
        main: PathBuf,
    },
    /// A file of raw voxels whose size or type is unknown.
    #[error(
        "{}: its {what} is not known; give --dims X,Y,Z and --dtype, or name it like name_256x256x256_uint8.raw",
        plain(path.display())
    )]
    UnknownLayout {
        /// The file.
        path: PathBuf,
        /// The unknown property: size or type.
        what: &'static str,
    },
    /// More memory than there is.
    #[error("{}: {shortage}", plain(path.display()))]
    Memory {
        /// The file that is read or written.
        path: PathBuf,
        /// The memory needed and available, and advice.
        shortage: Shortage,
    },
}

/// The result of the operations of this crate.
pub type Result<T> = std::result::Result<T, Error>;

impl Error {
    /// The system refused `action` on `path`.
    pub fn io(action: &'static str, path: &Path, source: io::Error) -> Self {
        Self::Io { action, path: path.to_owned(), source }
    }

    /// `path` is damaged.
    pub fn malformed(path: &Path, problem: impl Into<String>) -> Self {
        Self::Malformed { path: path.to_owned(), problem: problem.into() }
    }

    /// There is not enough memory for `path`.
    pub fn memory(path: &Path, shortage: Shortage) -> Self {
        Self::Memory { path: path.to_owned(), shortage }
    }

    /// An [`Error::Unsupported`] for `path`.
    pub fn unsupported(path: &Path, problem: impl Into<String>) -> Self {
        Self::Unsupported { path: path.to_owned(), problem: problem.into() }
    }
}

fn advice(error: &io::Error) -> &'static str {
    match error.kind() {
        io::ErrorKind::NotFound => "; check the path",
        io::ErrorKind::PermissionDenied => "; check the permissions",
        io::ErrorKind::OutOfMemory => "; free some memory, or raise the limit (`ulimit -v`)",
        io::ErrorKind::StorageFull => "; free some space or choose another folder",
        _ => "",
    }
}

/// `text` for one line of a terminal: what hostile files smuggle into names and values is escaped.
pub(crate) fn plain(text: impl Display) -> String {
    let shown = |c: char| if c.is_control() { c.escape_default().to_string() } else { c.to_string() };
    text.to_string().chars().map(shown).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_are_one_line_of_plain_text() {
        let error = Error::malformed(Path::new("a\nb.nrrd"), "its type `\x1b[2J\r` is no type");
        assert_eq!(error.to_string(), r"a\nb.nrrd: its type `\u{1b}[2J\r` is no type");
        let error = Error::io("read", Path::new("\tx"), io::ErrorKind::NotFound.into());
        assert!(error.to_string().starts_with(r"cannot read \tx: "), "{error}");
    }
}
