use super::digest::{record_hash, recorded, sha512_of};
use super::error::KnownHash;
use super::progress::{Progress, Watch};
use super::transfer::receive;
use super::{Entry, Error, Result};
use crate::atomic;
use std::fmt;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

/// A published volume on this machine.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Outcome {
    /// The file.
    pub path: PathBuf,
    /// How it came there.
    pub origin: Origin,
    /// The reference that its hash was compared to.
    pub check: Check,
}

/// How a file came to be on this machine.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Origin {
    /// It was there already.
    Present,
    /// It was downloaded.
    Downloaded {
        /// Bytes that an earlier, interrupted run had left; 0 for a download in one go.
        resumed_from: u64,
    },
}

/// Reference that the SHA-512 of a file was compared to.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Check {
    /// The published hash.
    Published,
    /// The hash that an earlier download recorded.
    Recorded,
    /// Nothing: no hash was known. That of this file is now in `record`, for the next time.
    FirstSeen {
        /// Where the hash was written.
        record: PathBuf,
    },
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: ", self.path.display())?;
        match self.origin {
            Origin::Present => f.write_str("already there")?,
            Origin::Downloaded { resumed_from: 0 } => f.write_str("downloaded")?,
            Origin::Downloaded { resumed_from } => write!(f, "download resumed at byte {resumed_from}")?,
        }
        match &self.check {
            Check::Published => f.write_str(", SHA-512 is the published one"),
            Check::Recorded => f.write_str(", SHA-512 is that of the first download"),
            Check::FirstSeen { record } => {
                write!(f, ", no SHA-512 is published: not checked, recorded in {}", record.display())
            }
        }
    }
}

/// Puts the volume `entry` into `folder`, unless it is there already, and checks its hash.
///
/// Bytes are received into `NAME.part`; the file gets its name when it is complete and its hash is the
/// published one, or that of an earlier download, or the first that is seen. An interrupted download goes
/// on where it stopped. `listener` hears of progress; when `cancel` becomes true, the job stops and the
/// `.part` file stays.
///
/// ```no_run
/// use fovol_io::dataset::{find, get};
/// use std::path::Path;
/// use std::sync::atomic::AtomicBool;
///
/// let never = AtomicBool::new(false);
/// let got = get(find("aneurism")?, Path::new("volumes"), &mut |p| println!("{} of {}", p.done, p.total), &never)?;
/// println!("{got}");
/// # Ok::<(), fovol_io::dataset::Error>(())
/// ```
///
/// # Errors
/// See [`Error`]. Under the final name there is never anything incomplete or unchecked.
pub fn get(
    entry: &Entry,
    folder: &Path,
    listener: &mut dyn FnMut(Progress),
    cancel: &AtomicBool,
) -> Result<Outcome> {
    let mut watch = Watch { listener, cancel };
    atomic::make_folder(folder)?;
    let place = Place::new(entry, folder);
    let known = place.known_hash(entry)?;
    if place.path.exists() {
        return place.check_present(entry, known.as_ref(), &mut watch);
    }
    let resumed_from = receive(&entry.url, entry.bytes(), &place.part, &mut watch)?;
    let found = place.hash_of(&place.part, &mut watch)?;
    if let Some(known) = &known
        && known.hash() != found
    {
        fs::remove_file(&place.part).map_err(|e| crate::Error::io("remove", &place.part, e))?;
        return Err(Error::HashDiffers { url: entry.url.clone(), found, known: known.clone() });
    }
    place.complete()?;
    let check = place.settle(known.as_ref(), &found)?;
    Ok(Outcome { path: place.path, origin: Origin::Downloaded { resumed_from }, check })
}

/// The files of one entry.
struct Place {
    name: String,
    path: PathBuf,
    part: PathBuf,
    record: PathBuf,
}

impl Place {
    fn new(entry: &Entry, folder: &Path) -> Self {
        let name = entry.file_name();
        let beside = |suffix: &str| folder.join(format!("{name}{suffix}"));
        Self { path: beside(""), part: beside(".part"), record: beside(".sha512"), name }
    }

    fn known_hash(&self, entry: &Entry) -> Result<Option<KnownHash>> {
        if let Some(hash) = &entry.sha512 {
            return Ok(Some(KnownHash::Published(hash.clone())));
        }
        let record = self.record.clone();
        Ok(recorded(&self.record)?.map(|hash| KnownHash::Recorded { hash, record }))
    }

    fn check_present(
        self,
        entry: &Entry,
        known: Option<&KnownHash>,
        watch: &mut Watch<'_>,
    ) -> Result<Outcome> {
        let occupied = |problem: String| Error::Occupied { path: self.path.clone(), problem };
        let length = fs::metadata(&self.path).map_err(|e| crate::Error::io("read", &self.path, e))?.len();
        if length != entry.bytes() {
            return Err(occupied(format!("has {length} bytes instead of {}", entry.bytes())));
        }
        let found = self.hash_of(&self.path, watch)?;
        if known.is_some_and(|known| known.hash() != found) {
            return Err(occupied("its SHA-512 is not the known one".into()));
        }
        let check = self.settle(known, &found)?;
        Ok(Outcome { path: self.path, origin: Origin::Present, check })
    }

    fn hash_of(&self, path: &Path, watch: &mut Watch<'_>) -> Result<String> {
        sha512_of(path, watch)?.ok_or_else(|| Error::Cancelled { part: path.into() })
    }

    /// Gives the checked download its name.
    #[expect(
        clippy::disallowed_methods,
        reason = "the file is complete and on disk already: only its name changes"
    )]
    fn complete(&self) -> Result<()> {
        fs::rename(&self.part, &self.path).map_err(|e| crate::Error::io("rename", &self.part, e).into())
    }

    /// Says what `found` was compared to; where that is nothing, records it.
    fn settle(&self, known: Option<&KnownHash>, found: &str) -> Result<Check> {
        Ok(match known {
            Some(KnownHash::Published(_)) => Check::Published,
            Some(KnownHash::Recorded { .. }) => Check::Recorded,
            None => {
                record_hash(&self.record, found, &self.name)?;
                Check::FirstSeen { record: self.record.clone() }
            }
        })
    }
}
