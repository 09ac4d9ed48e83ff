//! A hierarchy in a folder of the file system.

use super::{Blob, Store};
use crate::natural_order;
use memmap2::Mmap;
use std::fs::File;
use std::io::{self, Read};
use std::path::PathBuf;

/// A folder.
pub struct Folder {
    root: PathBuf,
}

impl Folder {
    /// The hierarchy in the folder `root`.
    pub fn new(root: PathBuf) -> Self {
        Self { root }
    }

    /// The file of `key`; none if there is none. Folders, pipes and devices are none.
    fn file(&self, key: &str) -> io::Result<Option<(File, usize)>> {
        let file = match File::open(self.root.join(key)) {
            Ok(file) => file,
            Err(e) if is_absence(&e) => return Ok(None),
            Err(e) => return Err(e),
        };
        let found = file.metadata()?;
        Ok(found.is_file().then_some((file, usize::try_from(found.len()).unwrap_or(usize::MAX))))
    }
}

/// Whether an error means that there is no file: a name below a file is no file either.
fn is_absence(error: &io::Error) -> bool {
    matches!(error.kind(), io::ErrorKind::NotFound | io::ErrorKind::NotADirectory)
}

impl Store for Folder {
    fn read(&self, key: &str, out: &mut Vec<u8>) -> io::Result<bool> {
        out.clear();
        let Some((mut file, length)) = self.file(key)? else { return Ok(false) };
        out.try_reserve(length).map_err(|_| io::ErrorKind::OutOfMemory)?;
        file.read_to_end(out)?;
        Ok(true)
    }

    fn open(&self, key: &str) -> io::Result<Option<Box<dyn Blob>>> {
        let Some((file, length)) = self.file(key)? else { return Ok(None) };
        if length == 0 {
            return Ok(Some(Box::new(Vec::new())));
        }
        // SAFETY: the map is read-only; that nobody shortens the file meanwhile is the documented condition of every
        // program that maps files.
        Ok(Some(Box::new(unsafe { Mmap::map(&file) }?)))
    }

    fn has(&self, key: &str) -> bool {
        self.root.join(key).is_file()
    }

    fn folders(&self, key: &str) -> Vec<String> {
        let entries = std::fs::read_dir(self.root.join(key)).into_iter().flatten().flatten();
        let folders = entries.filter(|entry| entry.path().is_dir());
        let mut names: Vec<String> =
            folders.filter_map(|folder| folder.file_name().into_string().ok()).collect();
        names.sort_by(|a, b| natural_order::compare(a, b));
        names
    }
}
