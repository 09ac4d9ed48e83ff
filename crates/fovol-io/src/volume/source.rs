use crate::{Error, Result};
use fovol_core::memory::{self, Shortage};
use fovol_core::{VoxelBytes, input};
use memmap2::Mmap;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The error for a file of `length` bytes that cannot be memory-mapped.
fn too_large(length: u64) -> Shortage {
    Shortage {
        what: "opening the file".into(),
        needed: length,
        available: memory::available(),
        parts: Vec::new(),
        advice: "raise the limit (`ulimit -v`), or convert it with --downsample 2 where there is more memory",
    }
}

/// The bytes of one file, mapped or in memory, and its name for messages and siblings.
#[derive(Clone)]
pub struct Source {
    path: PathBuf,
    bytes: VoxelBytes,
}

impl Source {
    /// Maps the file at `path`. It must not be cut short by others while it is in use.
    ///
    /// # Errors
    /// Errors of the operating system.
    pub fn open(path: &Path) -> Result<Self> {
        let failed = |source| Error::io("read", path, source);
        let file = input::open(path).map_err(failed)?;
        let length = file.metadata().map_err(failed)?.len();
        if length == 0 {
            return Ok(Self::from_bytes(path, Vec::new()));
        }
        // SAFETY: the map is read-only; that nobody shortens the file meanwhile is the documented condition
        // of every program that maps files.
        let map = unsafe { Mmap::map(&file) }.map_err(|e| match e.kind() {
            io::ErrorKind::OutOfMemory => Error::memory(path, too_large(length)),
            _ => failed(e),
        })?;
        Ok(Self { path: path.to_owned(), bytes: Arc::new(map) })
    }

    /// A file that is in memory already; `path` names it in messages and locates its siblings.
    pub fn from_bytes(path: &Path, bytes: Vec<u8>) -> Self {
        Self { path: path.to_owned(), bytes: Arc::new(bytes) }
    }

    /// The name of the file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// All bytes.
    pub fn bytes(&self) -> &[u8] {
        (*self.bytes).as_ref()
    }

    /// All bytes, to be shared with a volume.
    pub fn shared(&self) -> VoxelBytes {
        Arc::clone(&self.bytes)
    }

    /// Opens the file that this one calls `name`: relative to its folder, never above it by surprise.
    ///
    /// # Errors
    /// Errors of the operating system, with the advice to keep both files together.
    pub fn sibling(&self, name: &str) -> Result<Self> {
        let path = self.sibling_path(name);
        if !path.exists() {
            return Err(self.malformed(format!(
                "its data file {} is missing; put it beside this file under that name",
                path.display()
            )));
        }
        Self::open(&path)
    }

    /// Where the file that this one calls `name` should be.
    pub fn sibling_path(&self, name: &str) -> PathBuf {
        self.path.parent().unwrap_or(Path::new("")).join(name)
    }

    /// The error for a file that is cut short or changed.
    pub fn damaged(&self) -> Error {
        self.malformed("it is damaged or cut short; copy or download it again")
    }

    /// The file is damaged.
    pub fn malformed(&self, problem: impl Into<String>) -> Error {
        Error::malformed(&self.path, problem)
    }

    /// The error for a format or feature that is not supported.
    pub fn unsupported(&self, problem: impl Into<String>) -> Error {
        Error::unsupported(&self.path, problem)
    }
}
