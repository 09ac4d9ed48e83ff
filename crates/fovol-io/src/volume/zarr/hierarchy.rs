//! Groups and arrays by their paths.

use super::json::{Object, parse};
use super::metadata::{Node, array_v2, group_v2, node_v3};
use super::store::Store;
use crate::volume::Source;
use crate::{Error, Result};
use std::io;

/// An open hierarchy.
pub struct Hierarchy<'a> {
    /// The file or folder, for messages.
    pub source: &'a Source,
    /// Its files.
    pub store: &'a dyn Store,
}

/// Files of metadata are no longer than this.
const LONGEST_METADATA: usize = 64 << 20;

impl Hierarchy<'_> {
    /// The group or array at `path`; none if there is none.
    ///
    /// # Errors
    /// Metadata that cannot be read.
    pub fn node(&self, path: &str) -> Result<Option<Node>> {
        if let Some(said) = self.metadata(path, "zarr.json")? {
            let node = node_v3(said).map_err(|problem| self.malformed(path, &problem))?;
            return Ok(Some(node));
        }
        let attributes = || self.metadata(path, ".zattrs");
        if let Some(said) = self.metadata(path, ".zarray")? {
            return Ok(Some(array_v2(&said, attributes()?)));
        }
        let is_group = self.store.has(&key(path, ".zgroup"));
        let attributes = attributes()?;
        Ok((is_group || attributes.is_some()).then(|| group_v2(attributes)))
    }

    /// The object in the file `name` of the node at `path`; none if there is no such file.
    fn metadata(&self, path: &str, name: &str) -> Result<Option<Object>> {
        let (key, mut text) = (key(path, name), Vec::new());
        if !self.store.read(&key, &mut text).map_err(|e| self.failed(e))? {
            return Ok(None);
        }
        if text.len() > LONGEST_METADATA {
            return Err(self.malformed(path, &format!("has a `{name}` that is too long; write it again")));
        }
        parse(&text).map(Some).map_err(|problem| self.source.malformed(format!("its `{key}` {problem}")))
    }

    /// The error for a problem of the node at `path`.
    pub fn malformed(&self, path: &str, problem: &str) -> Error {
        self.source.malformed(match path {
            "" => format!("it {problem}"),
            path => format!("its `{path}` {problem}"),
        })
    }

    /// The error for a failure of the store.
    pub fn failed(&self, problem: io::Error) -> Error {
        match problem.downcast() {
            Ok(problem) => problem,
            Err(problem) => Error::io("read", self.source.path(), problem),
        }
    }
}

/// The key of the file `name` of the node at `path`.
pub fn key(path: &str, name: &str) -> String {
    if path.is_empty() { name.to_owned() } else { format!("{path}/{name}") }
}

/// The path `path` below the group `parent`, without dots and doubled slashes; none if it leads out of the hierarchy.
pub fn joined(parent: &str, path: &str) -> Option<String> {
    let parts = parent.split('/').chain(path.split('/')).filter(|part| !part.is_empty() && *part != ".");
    let parts: Vec<&str> = parts.collect();
    let is_sound = |part: &&str| *part != ".." && !part.contains(['\\', '\0']);
    parts.iter().all(is_sound).then(|| parts.join("/"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_stay_in_the_hierarchy() {
        assert_eq!(joined("a/b", "./c//d/").as_deref(), Some("a/b/c/d"));
        assert_eq!(joined("", "/").as_deref(), Some(""));
        for path in ["..", "a/../b", "a\\b", "a\0"] {
            assert_eq!(joined("x", path), None, "{path}");
        }
    }
}
