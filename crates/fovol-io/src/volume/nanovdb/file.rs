//! Segments of a file, each with a list of its grids and the grids behind it.

use crate::Result;
use crate::volume::Source;
use crate::volume::blosc;
use crate::volume::decompress::{Compression, decompress};
use std::borrow::Cow;

/// First bytes of files and of grids: version 0 of both, a grid, a file.
const MAGIC: [&[u8]; 3] = [b"NanoVDB0", b"NanoVDB1", b"NanoVDB2"];

/// Bytes of the head of a segment, and of what it says of each grid before its name.
const HEAD: usize = 16;
const ENTRY: usize = 176;

/// The version whose grids are read; versions within it have the same structs.
const MAJOR: u32 = 32;

/// Bytes that Blosc packs at once.
const PIECE: usize = 1 << 30;

/// How a grid is packed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Codec {
    Plain,
    Zlib,
    Blosc,
}

/// A grid in a file.
#[derive(Debug, Clone)]
pub struct Entry {
    /// Its name.
    pub name: String,
    /// The number of its type.
    pub kind: u32,
    codec: Codec,
    /// Where its bytes begin, and how many there are, packed and not.
    start: usize,
    packed: usize,
    length: usize,
}

/// Whether `bytes` are those of a NanoVDB file or grid.
pub fn is_nanovdb(bytes: &[u8]) -> bool {
    MAGIC.iter().any(|magic| bytes.starts_with(magic))
}

/// All grids of `source`.
///
/// # Errors
/// Damage, versions and codecs that are not read.
pub fn entries(source: &Source) -> Result<Vec<Entry>> {
    let bytes = source.bytes();
    if !is_nanovdb(bytes) {
        return Err(source.malformed("it does not begin like a NanoVDB file; is the name right?"));
    }
    // A grid without a file around it has its version farther behind.
    if bytes[7] == b'1'
        || u32_at(bytes, 8).map(major) != Some(MAJOR) && u32_at(bytes, 16).map(major) == Some(MAJOR)
    {
        return Ok(vec![bare(bytes).ok_or_else(|| source.damaged())?]);
    }
    let mut found = Vec::new();
    let mut at = 0;
    while at < bytes.len() {
        let segment = bytes.get(at..).filter(|rest| is_nanovdb(rest)).ok_or_else(|| source.damaged())?;
        let version = u32_at(segment, 8).ok_or_else(|| source.damaged())?;
        if major(version) != MAJOR {
            return Err(source.unsupported(format!(
                "it has version {}.{} of NanoVDB; version {MAJOR} is read, so write it again with nanovdb_convert",
                major(version),
                version >> 10 & 0x7FF
            )));
        }
        at = segment_at(bytes, at, &mut found).ok_or_else(|| source.damaged())?;
    }
    Ok(found)
}

fn major(version: u32) -> u32 {
    version >> 21
}

/// Adds the grids of the segment at `at` to `found`, and returns where it ends.
fn segment_at(bytes: &[u8], at: usize, found: &mut Vec<Entry>) -> Option<usize> {
    let count = u16_at(bytes, at + 12)?;
    let codec = match u16_at(bytes, at + 14)? {
        0 => Codec::Plain,
        1 => Codec::Zlib,
        2 => Codec::Blosc,
        _ => return None,
    };
    let first = found.len();
    let mut at = at + HEAD;
    for _ in 0..count {
        let [length, packed] = [u64_at(bytes, at)?, u64_at(bytes, at + 8)?].map(usize::try_from);
        let kind = u32_at(bytes, at + 32)?;
        let name = u32_at(bytes, at + 136)? as usize;
        let name = bytes.get(at + ENTRY..(at + ENTRY).checked_add(name)?)?;
        at += ENTRY + name.len();
        let name = String::from_utf8_lossy(name).trim_end_matches('\0').to_owned();
        found.push(Entry { name, kind, codec, start: 0, packed: packed.ok()?, length: length.ok()? });
    }
    for entry in &mut found[first..] {
        entry.start = at;
        at = at.checked_add(entry.packed).filter(|&end| end <= bytes.len())?;
    }
    Some(at)
}

/// The entry of a grid without a file around it.
fn bare(bytes: &[u8]) -> Option<Entry> {
    let name = bytes.get(40..296)?;
    let name = String::from_utf8_lossy(name.split(|&byte| byte == 0).next()?).into_owned();
    let kind = u32_at(bytes, 636)?;
    Some(Entry { name, kind, codec: Codec::Plain, start: 0, packed: bytes.len(), length: bytes.len() })
}

impl Entry {
    /// The bytes of the grid.
    ///
    /// # Errors
    /// Damage, codecs of Blosc that are not read, too little memory.
    pub fn bytes<'a>(&self, source: &'a Source) -> Result<Cow<'a, [u8]>> {
        let damaged = || source.damaged();
        let packed = source.bytes().get(self.start..self.start + self.packed).ok_or_else(damaged)?;
        match self.codec {
            Codec::Plain => Ok(packed.get(..self.length).ok_or_else(damaged)?.into()),
            Codec::Zlib => {
                let packed = piece(packed).ok_or_else(damaged)?.0;
                Ok(decompress(source, packed, Compression::Zlib, self.length)?.into())
            }
            Codec::Blosc => self.of_blosc(source, packed).map(Cow::Owned),
        }
    }

    fn of_blosc(&self, source: &Source, mut packed: &[u8]) -> Result<Vec<u8>> {
        let mut out = Vec::new();
        while out.len() < self.length {
            let (chunk, rest) = piece(packed).ok_or_else(|| source.damaged())?;
            let unpacked = blosc::unpacked(chunk, PIECE).map_err(|problem| match problem {
                blosc::Problem::Damaged => source.damaged(),
                blosc::Problem::Codec(name) => source.unsupported(format!(
                    "it is packed by Blosc with {name}, which is not read; write it with zip, or with Blosc's own LZ4"
                )),
            })?;
            if unpacked.is_empty() {
                return Err(source.damaged());
            }
            out.extend_from_slice(&unpacked);
            packed = rest;
        }
        Ok(out)
    }
}

/// The bytes behind their number, and the rest.
fn piece(bytes: &[u8]) -> Option<(&[u8], &[u8])> {
    let (length, rest) = bytes.split_first_chunk()?;
    rest.split_at_checked(usize::try_from(u64::from_le_bytes(*length)).ok()?)
}

fn u16_at(bytes: &[u8], at: usize) -> Option<u16> {
    bytes.get(at..)?.first_chunk().map(|number| u16::from_le_bytes(*number))
}

/// The number of 32 bits at `at`.
pub fn u32_at(bytes: &[u8], at: usize) -> Option<u32> {
    bytes.get(at..)?.first_chunk().map(|number| u32::from_le_bytes(*number))
}

/// The number of 64 bits at `at`.
pub fn u64_at(bytes: &[u8], at: usize) -> Option<u64> {
    bytes.get(at..)?.first_chunk().map(|number| u64::from_le_bytes(*number))
}
