//! Keeps what tuners chose, for the next run of a program.

use crate::pipeline_cache::folder;
use std::collections::BTreeMap;
use std::io::Write;
use std::path::PathBuf;

/// Choices that tuners of this user made before: a key has a candidate and its milliseconds.
///
/// They lie in a file beside the compiled pipelines. They only save time: where the file cannot be read or written, everything is
/// tried anew.
#[derive(Debug, Clone, Default)]
pub struct Choices {
    file: Option<PathBuf>,
    known: BTreeMap<String, (String, f64)>,
}

/// Name of the file. A line has key, candidate and milliseconds, with tabs between them.
const FILE: &str = "choices.tsv";
/// Most choices that are kept.
const MOST: usize = 1000;

impl Choices {
    /// Choices of this user.
    pub fn of_user() -> Self {
        folder().map_or_else(Self::default, |folder| Self::of_file(folder.join(FILE)))
    }

    fn of_file(file: PathBuf) -> Self {
        let text = std::fs::read_to_string(&file).unwrap_or_default();
        let known = text.lines().filter_map(|line| {
            let mut parts = line.split('\t');
            let (key, candidate, ms) = (parts.next()?, parts.next()?, parts.next()?.parse::<f64>().ok()?);
            (ms > 0.0 && ms.is_finite()).then(|| (key.to_owned(), (candidate.to_owned(), ms)))
        });
        Self { known: known.take(MOST).collect(), file: Some(file) }
    }

    /// Candidate that was chosen for `key`, and its milliseconds.
    pub fn get(&self, key: &str) -> Option<(&str, f64)> {
        self.known.get(key).map(|(candidate, ms)| (candidate.as_str(), *ms))
    }

    /// Keeps the `candidate` that was chosen for `key` by its `ms` milliseconds. Neither has tabs or line breaks.
    pub fn keep(&mut self, key: &str, candidate: &str, ms: f64) {
        let Some(file) = &self.file else { return };
        // Another program may have written since.
        self.known = Self::of_file(file.clone()).known;
        self.known.insert(key.to_owned(), (candidate.to_owned(), ms));
        // An error only means that the next run tries again.
        let _ = self.save();
    }

    fn save(&self) -> std::io::Result<()> {
        let Some((file, folder)) = self.file.as_ref().and_then(|file| Some((file, file.parent()?))) else {
            return Ok(());
        };
        std::fs::create_dir_all(folder)?;
        let mut unfinished = tempfile::NamedTempFile::new_in(folder)?;
        for (key, (candidate, ms)) in &self.known {
            writeln!(unfinished, "{key}\t{candidate}\t{ms:.6}")?;
        }
        unfinished.persist(file)?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn choices_are_found_again() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("new").join(FILE);
        let mut first = Choices::of_file(file.clone());
        assert_eq!(first.get("a"), None);
        first.keep("a", "pool:4,128", 0.25);
        // Two programs that write in turn keep both.
        let mut second = Choices::of_file(file.clone());
        first.keep("b", "rays", 1.0);
        second.keep("c", "rays", 2.0);
        let all = Choices::of_file(file.clone());
        assert_eq!(all.get("a"), Some(("pool:4,128", 0.25)));
        assert!(all.get("b").is_some() && all.get("c").is_some());
        std::fs::write(&file, "a\tx\nb\ty\tnan\nc\tz\t-1\nd\tw\t3.5\textra\n\u{0}").unwrap();
        let damaged = Choices::of_file(file);
        assert_eq!((damaged.get("a"), damaged.get("b"), damaged.get("c")), (None, None, None));
        assert_eq!(damaged.get("d"), Some(("w", 3.5)));
    }

    #[test]
    fn nothing_is_kept_without_a_folder() {
        let mut choices = Choices::default();
        choices.keep("a", "rays", 1.0);
        assert_eq!(choices.get("a"), None);
    }
}
