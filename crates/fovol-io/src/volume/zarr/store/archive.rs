//! A hierarchy in a zip archive.

use super::index::Index;
use super::{Blob, Store};
use crate::volume::Source;
use crate::volume::zip::members;
use fovol_core::VoxelBytes;
use std::io;

/// A zip archive in a file. Its hierarchy may lie in one folder of it.
pub struct Archive<'a> {
    source: &'a Source,
    index: Index,
}

impl<'a> Archive<'a> {
    /// The hierarchy in the archive `source`; none if it holds none.
    ///
    /// # Errors
    /// A damaged directory.
    pub fn open(source: &'a Source) -> crate::Result<Option<Self>> {
        Ok(Index::of(members(source)?).map(|index| Self { source, index }))
    }

    fn bytes(&self, key: &str) -> io::Result<Option<Bytes>> {
        let Some(member) = self.index.member(key) else { return Ok(None) };
        let (bytes, start) = member.bytes(self.source).map_err(io::Error::other)?;
        Ok(Some(Bytes { bytes, start, length: member.length() }))
    }
}

impl Store for Archive<'_> {
    fn read(&self, key: &str, out: &mut Vec<u8>) -> io::Result<bool> {
        out.clear();
        let Some(bytes) = self.bytes(key)? else { return Ok(false) };
        out.extend_from_slice(bytes.as_ref());
        Ok(true)
    }

    fn open(&self, key: &str) -> io::Result<Option<Box<dyn Blob>>> {
        Ok(self.bytes(key)?.map(|bytes| Box::new(bytes) as Box<dyn Blob>))
    }

    fn has(&self, key: &str) -> bool {
        self.index.member(key).is_some()
    }

    fn folders(&self, key: &str) -> Vec<String> {
        self.index.folders(key)
    }
}

/// A member of an archive: bytes that are shared with it, or unpacked.
struct Bytes {
    bytes: VoxelBytes,
    start: usize,
    length: usize,
}

impl AsRef<[u8]> for Bytes {
    fn as_ref(&self) -> &[u8] {
        let bytes = (*self.bytes).as_ref();
        // A stored member is as long as it is packed; others may not lead beyond what they hold.
        let end = self.start.saturating_add(self.length).min(bytes.len());
        &bytes[self.start.min(end)..end]
    }
}
