//! Files of metadata that were read from the web, where each is asked for once.

use super::metadata::is_metadata;
use std::collections::HashMap;
use std::io;
use std::sync::{Arc, Mutex, PoisonError};

/// Metadata that were read already, by key; none where there is no such file.
#[derive(Default)]
pub struct Known(Mutex<HashMap<String, Option<Arc<[u8]>>>>);

impl Known {
    /// Replaces the content of `out` by the file `key`, which `get` reads. Returns whether there is such a file. `get` is
    /// asked once for a file of metadata.
    ///
    /// # Errors
    /// Those of `get`.
    pub fn read(
        &self,
        key: &str,
        out: &mut Vec<u8>,
        get: impl FnOnce() -> io::Result<Option<Vec<u8>>>,
    ) -> io::Result<bool> {
        out.clear();
        if !is_metadata(key) {
            let found = get()?;
            let is_there = found.is_some();
            *out = found.unwrap_or_default();
            return Ok(is_there);
        }
        let known = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let cached = known().get(key).cloned();
        let file = match cached {
            Some(file) => file,
            None => {
                let file = get()?.map(Arc::from);
                known().insert(key.to_owned(), file.clone());
                file
            }
        };
        out.extend_from_slice(file.as_deref().unwrap_or_default());
        Ok(file.is_some())
    }
}
