//! Places that hold the files of a Zarr hierarchy: a folder or a zip archive, here or on a web server.

mod archive;
mod folder;
mod index;
#[cfg(feature = "remote")]
mod known_metadata;
mod metadata;
#[cfg(feature = "remote")]
mod remote;
#[cfg(feature = "remote")]
mod remote_archive;
#[cfg(feature = "remote")]
mod web_file;

pub use archive::Archive;
pub use folder::Folder;
#[cfg(feature = "remote")]
pub use remote::Remote;
#[cfg(feature = "remote")]
pub use remote_archive::RemoteArchive;
use std::io;
use std::ops::Range;

/// Files under keys such as `a/b/zarr.json`.
pub trait Store: Sync {
    /// Replaces the content of `out` by the file `key`. Returns whether there is such a file.
    ///
    /// # Errors
    /// Errors of the system; a damaged archive.
    fn read(&self, key: &str, out: &mut Vec<u8>) -> io::Result<bool>;

    /// Opens the file `key` to read parts of it; none if there is no such file.
    ///
    /// # Errors
    /// Those of [`Self::read`].
    fn open(&self, key: &str) -> io::Result<Option<Box<dyn Blob>>>;

    /// Whether there is a file `key`.
    fn has(&self, key: &str) -> bool;

    /// Names of the folders in the folder `key`, in the natural order.
    fn folders(&self, key: &str) -> Vec<String>;
}

/// A file of which parts are read.
pub trait Blob: Sync {
    /// Bytes of the file.
    fn length(&self) -> usize;

    /// The bytes in `range`, which lies within the file, in place or read into `scratch`.
    ///
    /// # Errors
    /// Errors of the system.
    fn part<'a>(&'a self, range: Range<usize>, scratch: &'a mut Vec<u8>) -> io::Result<&'a [u8]>;
}

/// A file in memory.
impl<T: AsRef<[u8]> + Sync> Blob for T {
    fn length(&self) -> usize {
        self.as_ref().len()
    }

    fn part<'a>(&'a self, range: Range<usize>, _: &'a mut Vec<u8>) -> io::Result<&'a [u8]> {
        self.as_ref().get(range).ok_or_else(|| io::ErrorKind::UnexpectedEof.into())
    }
}
