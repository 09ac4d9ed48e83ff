//! A hierarchy in a zip archive on a web server.
//!
//! The server must send parts of files. First comes the directory at the end of the archive, then each member that is
//! read.

use super::index::Index;
use super::known_metadata::Known;
use super::web_file::{Answer, WebFile};
use super::{Blob, Store};
use crate::volume::Source;
use crate::volume::zip::{self, Directory, HEADER, LONGEST_END, Member, data_after};
use crate::{Error, Result};
use std::io;
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

/// Bytes of the largest directory that is read: some three million members.
const LARGEST_DIRECTORY: usize = 256 << 20;

/// Packed bytes of the largest member that is read whole.
const LARGEST_MEMBER: usize = 2 << 30;

/// Bytes of extra fields that most local headers do not exceed.
const EXTRA: usize = 128;

/// Larger members that are stored without compression are read in parts.
const WHOLE: usize = 64 << 10;

/// A zip archive on a web server.
pub struct RemoteArchive {
    archive: Arc<WebArchive>,
    index: Index,
    metadata: Known,
}

impl RemoteArchive {
    /// Whether the address `url` is that of an archive: its path ends in `.zip` or `.ozx`.
    pub fn is_named_by(url: &str) -> bool {
        let path = url.split(['?', '#']).next().unwrap_or_default().to_ascii_lowercase();
        [".zip", ".ozx"].iter().any(|ending| path.ends_with(ending))
    }

    /// The hierarchy in the archive at the address `url`; none if it holds none.
    ///
    /// # Errors
    /// A server that cannot be reached or sends no parts of files, no such file, a damaged directory.
    pub fn open(url: &str) -> Result<Option<Self>> {
        let path = Path::new(url);
        let failed = |error| Error::io("read", path, error);
        let archive = WebArchive::open(url).map_err(failed)?;
        let start = archive.length.saturating_sub(LONGEST_END);
        let tail = archive.part(start..archive.length).map_err(failed)?;
        let damaged = || zip::damaged(&archive.source);
        let directory = Directory::find(&tail, start).ok_or_else(damaged)?;
        let members = if let Some(within) = directory.start.checked_sub(start) {
            directory.members(tail.get(within..).ok_or_else(damaged)?)
        } else if start - directory.start > LARGEST_DIRECTORY {
            return Err(archive.source.unsupported(format!(
                "the directory of the archive has more than {} MiB; download the file first",
                LARGEST_DIRECTORY >> 20
            )));
        } else {
            let mut bytes = archive.part(directory.start..start).map_err(failed)?;
            bytes.extend_from_slice(&tail);
            directory.members(&bytes)
        };
        let index = Index::of(members.ok_or_else(damaged)?);
        Ok(index.map(|index| Self { archive: Arc::new(archive), index, metadata: Known::default() }))
    }

    /// The bytes of the member `key`; none if there is none.
    fn bytes(&self, key: &str) -> io::Result<Option<Vec<u8>>> {
        self.index.member(key).map(|member| self.archive.bytes(member)).transpose()
    }
}

impl Store for RemoteArchive {
    fn read(&self, key: &str, out: &mut Vec<u8>) -> io::Result<bool> {
        self.metadata.read(key, out, || self.bytes(key))
    }

    fn open(&self, key: &str) -> io::Result<Option<Box<dyn Blob>>> {
        let Some(member) = self.index.member(key) else { return Ok(None) };
        if !member.is_stored() || member.packed <= WHOLE {
            return Ok(Some(Box::new(self.archive.bytes(member)?)));
        }
        let (_, after) = self.archive.begun(member, 0)?;
        let start = member.header.saturating_add(after);
        let end = start.saturating_add(member.packed);
        if end > self.archive.length {
            return Err(io::Error::other(member.cut_short(&self.archive.source)));
        }
        Ok(Some(Box::new(Stored { archive: Arc::clone(&self.archive), range: start..end })))
    }

    fn has(&self, key: &str) -> bool {
        self.index.member(key).is_some()
    }

    fn folders(&self, key: &str) -> Vec<String> {
        self.index.folders(key)
    }
}

/// An archive on a web server, of which parts are read.
struct WebArchive {
    file: WebFile,
    length: usize,
    /// Names the archive in errors.
    source: Source,
}

impl WebArchive {
    fn open(url: &str) -> io::Result<Self> {
        let file = WebFile::new(url.to_owned(), WebFile::agent());
        let absent = || io::Error::other("there is no such file, or it needs a password; check the address");
        let length = match file.ask(0..4)?.ok_or_else(absent)? {
            Answer::Part(_, Some(length)) => length,
            Answer::Part(_, None) | Answer::Whole(_) => return Err(no_parts()),
        };
        let source = Source::from_bytes(Path::new(url), Vec::new());
        Ok(Self { file, length, source })
    }

    /// The bytes in `range`, which lies within the archive.
    fn part(&self, range: Range<usize>) -> io::Result<Vec<u8>> {
        if range.is_empty() {
            return Ok(Vec::new());
        }
        match self.file.ask(range.clone())? {
            Some(Answer::Part(part, _)) if part.len() == range.len() => Ok(part),
            Some(Answer::Part(..)) => Err(io::Error::other("it ends early")),
            // A part that is the whole file may come as such.
            Some(Answer::Whole(response)) if range == (0..self.length) => {
                let whole = self.file.body(*response, self.length as u64)?;
                Some(whole)
                    .filter(|whole| whole.len() == self.length)
                    .ok_or_else(|| io::Error::other("it ends early"))
            }
            Some(Answer::Whole(_)) => Err(no_parts()),
            None => Err(io::Error::other("the file is no longer there")),
        }
    }

    /// The archive from the local header of `member` on, with `data` bytes behind it at least, and the length of that header.
    fn begun(&self, member: &Member, data: usize) -> io::Result<(Vec<u8>, usize)> {
        let cut_short = || io::Error::other(member.cut_short(&self.source));
        let start = member.header;
        let guess = start.saturating_add(HEADER + member.name.len() + EXTRA).saturating_add(data);
        let read = guess.min(self.length);
        if start >= read {
            return Err(cut_short());
        }
        let mut bytes = self.part(start..read)?;
        let after = data_after(&bytes).ok_or_else(cut_short)?;
        let end = start.saturating_add(after).saturating_add(data);
        if end > self.length {
            return Err(cut_short());
        }
        // Long extra fields are seldom.
        if end > read {
            bytes.extend_from_slice(&self.part(read..end)?);
        }
        Ok((bytes, after))
    }

    /// The bytes of `member`, unpacked.
    fn bytes(&self, member: &Member) -> io::Result<Vec<u8>> {
        member.check_packing(&self.source).map_err(io::Error::other)?;
        if member.packed > LARGEST_MEMBER {
            let problem = format!("`{}` in it has more than 2 GiB; download the file first", member.name);
            return Err(io::Error::other(problem));
        }
        let (mut bytes, after) = self.begun(member, member.packed)?;
        bytes.truncate(after + member.packed);
        if member.is_stored() {
            bytes.drain(..after);
            return Ok(bytes);
        }
        member.inflated(&self.source, &bytes[after..]).map_err(io::Error::other)
    }
}

/// The error for a server that sends no parts of files.
fn no_parts() -> io::Error {
    io::Error::other(
        "the server sends no parts of files, which archives need; download the file first and name the copy",
    )
}

/// A member that is stored without compression, of which parts are read.
struct Stored {
    archive: Arc<WebArchive>,
    /// Its bytes in the archive.
    range: Range<usize>,
}

impl Blob for Stored {
    fn length(&self) -> usize {
        self.range.len()
    }

    fn part<'a>(&'a self, range: Range<usize>, scratch: &'a mut Vec<u8>) -> io::Result<&'a [u8]> {
        if range.end > self.range.len() {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        *scratch = self.archive.part(self.range.start + range.start..self.range.start + range.end)?;
        Ok(scratch)
    }
}
