//! The files of a hierarchy in a zip archive.

use super::metadata::is_metadata;
use crate::natural_order;
use crate::volume::zip::Member;
use std::collections::{BTreeSet, HashMap};

/// Members of an archive by their keys in the hierarchy, which may lie in one folder of it.
pub struct Index {
    members: HashMap<String, Member>,
    /// Names of folders by the folder that they are in.
    folders: HashMap<String, BTreeSet<String>>,
}

/// Deepest folders of an archive that are listed.
const DEEPEST: usize = 64;

impl Index {
    /// The hierarchy in an archive of the members `all`; none if it holds none.
    pub fn of(all: Vec<Member>) -> Option<Self> {
        let metadata = all.iter().map(|member| member.name.as_str()).filter(|name| is_metadata(name));
        // The shallowest metadata are those of the root.
        let first = metadata.min_by_key(|name| (name.matches('/').count(), name.len()))?;
        let root = first[..first.rfind('/').map_or(0, |at| at + 1)].to_owned();
        let mut index = Self { members: HashMap::new(), folders: HashMap::new() };
        for member in all {
            let Some(key) = member.name.strip_prefix(root.as_str()).filter(|key| !key.ends_with('/')) else {
                continue;
            };
            index.add_folders(key);
            index.members.insert(key.to_owned(), member);
        }
        Some(index)
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

    /// The member under `key`.
    pub fn member(&self, key: &str) -> Option<&Member> {
        self.members.get(key)
    }

    /// Names of the folders in the folder `key`, in the natural order.
    pub fn folders(&self, key: &str) -> Vec<String> {
        let mut names: Vec<String> = self.folders.get(key).into_iter().flatten().cloned().collect();
        names.sort_by(|a, b| natural_order::compare(a, b));
        names
    }
}
