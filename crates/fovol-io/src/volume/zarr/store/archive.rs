//! A hierarchy in a zip archive.

use super::{Blob, Store};
use crate::natural_order;
use crate::volume::Source;
use crate::volume::zip::{Member, members};
use fovol_core::VoxelBytes;
use std::collections::{BTreeSet, HashMap};
use std::io;

/// A zip archive. Its hierarchy may lie in one folder of it.
pub struct Archive<'a> {
    source: &'a Source,
    members: HashMap<String, Member>,
    /// Names of folders by the folder that they are in.
    folders: HashMap<String, BTreeSet<String>>,
}

/// Names of files that hold metadata.
const METADATA: [&str; 4] = ["zarr.json", ".zattrs", ".zgroup", ".zarray"];

/// Deepest folders of an archive that are listed.
const DEEPEST: usize = 64;

impl<'a> Archive<'a> {
    /// The hierarchy in the archive `source`; none if it holds none.
    ///
    /// # Errors
    /// A damaged directory.
    pub fn open(source: &'a Source) -> crate::Result<Option<Self>> {
        let all = members(source)?;
        let files = || all.iter().map(|member| member.name.as_str());
        // The shallowest metadata are those of the root.
        let metadata = files().filter(|name| METADATA.contains(&name.rsplit('/').next().unwrap_or_default()));
        let Some(first) = metadata.min_by_key(|name| (name.matches('/').count(), name.len())) else {
            return Ok(None);
        };
        let root = first[..first.rfind('/').map_or(0, |at| at + 1)].to_owned();
        let mut archive = Self { source, members: HashMap::new(), folders: HashMap::new() };
        for member in all {
            let Some(key) = member.name.strip_prefix(root.as_str()).filter(|key| !key.ends_with('/')) else {
                continue;
            };
            archive.add_folders(key);
            archive.members.insert(key.to_owned(), member);
        }
        Ok(Some(archive))
    }

    /// Notes the folders that lead to the file `key`.
    fn add_folders(&mut self, key: &str) {
        for (at, _) in key.match_indices('/').take(DEEPEST) {
            let (parent, name) = key[..at].rsplit_once('/').unwrap_or(("", &key[..at]));
            if let Some(known) = self.folders.get_mut(parent) {
                if !known.contains(name) {
                    known.insert(name.to_owned());
                }
            } else {
                self.folders.insert(parent.to_owned(), BTreeSet::from([name.to_owned()]));
            }
        }
    }

    fn bytes(&self, key: &str) -> io::Result<Option<Bytes>> {
        let Some(member) = self.members.get(key) else { return Ok(None) };
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
        self.members.contains_key(key)
    }

    fn folders(&self, key: &str) -> Vec<String> {
        let mut names: Vec<String> = self.folders.get(key).into_iter().flatten().cloned().collect();
        names.sort_by(|a, b| natural_order::compare(a, b));
        names
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
