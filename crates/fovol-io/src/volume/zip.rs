//! The members of a zip archive, stored or deflated, with zip64:
//! <https://pkware.cachefly.net/webdocs/casestudies/APPNOTE.TXT>.

use crate::volume::Source;
use crate::volume::decompress::{Compression, beginning, decompress};
use crate::{Error, Result};
use flate2::Crc;
use fovol_core::VoxelBytes;
use std::sync::Arc;

/// One file in an archive.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Member {
    /// Its name in the archive.
    pub name: String,
    method: u16,
    is_encrypted: bool,
    checksum: u32,
    /// Its bytes in the archive.
    pub packed: usize,
    length: usize,
    /// Position of its local header in the archive.
    pub header: usize,
}

/// The record at the end, the longest comment behind it, and the record of zip64 with its locator before it.
pub const LONGEST_END: usize = 22 + 0xFFFF + 20 + 56;

/// The members of the archive `source`, in the order of its directory.
///
/// # Errors
/// A damaged or missing directory.
pub fn members(source: &Source) -> Result<Vec<Member>> {
    let bytes = source.bytes();
    let found = Directory::find(bytes, 0).and_then(|found| found.members(bytes.get(found.start..)?));
    found.ok_or_else(|| damaged(source))
}

/// The error for an archive whose directory is damaged or missing.
pub fn damaged(source: &Source) -> Error {
    source
        .malformed("the directory at the end of the archive is damaged or missing; copy or download it again")
}

/// The directory of an archive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Directory {
    /// Position of its first entry in the archive.
    pub start: usize,
    /// Number of entries, as the archive says.
    count: u64,
}

impl Directory {
    /// Finds the directory by the last bytes of an archive, `tail`, which begin at the position `from` in it. The last
    /// [`LONGEST_END`] bytes are enough.
    ///
    /// None where the record at the end is damaged or missing.
    pub fn find(tail: &[u8], from: usize) -> Option<Self> {
        let first = tail.len().saturating_sub(LONGEST_END);
        let end =
            (first..tail.len().checked_sub(21)?).rev().find(|&at| tail[at..].starts_with(b"PK\x05\x06"))?;
        let (mut count, mut start) = (u64::from(u16_at(tail, end + 10)?), u64::from(u32_at(tail, end + 16)?));
        // A zip64 record stands before its locator, which stands before this end.
        if let Some(locator) = end.checked_sub(20)
            && tail[locator..].starts_with(b"PK\x06\x07")
        {
            let record = usize::try_from(u64_at(tail, locator + 8)?).ok()?.checked_sub(from)?;
            if tail.get(record..)?.starts_with(b"PK\x06\x06") {
                count = u64_at(tail, record.checked_add(32)?)?;
                start = u64_at(tail, record.checked_add(48)?)?;
            }
        }
        Some(Self { start: usize::try_from(start).ok()?, count })
    }

    /// The members that `bytes` list, which begin with the first entry; none if they are damaged.
    pub fn members(&self, bytes: &[u8]) -> Option<Vec<Member>> {
        let (mut members, mut at) = (Vec::new(), 0);
        for _ in 0..self.count {
            let (member, length) = Member::parse(bytes.get(at..)?)?;
            members.push(member);
            at += length;
        }
        Some(members)
    }
}

impl Member {
    /// The member whose directory entry begins `entry`, and the length of that entry.
    fn parse(entry: &[u8]) -> Option<(Self, usize)> {
        if !entry.starts_with(b"PK\x01\x02") {
            return None;
        }
        let [name, extra, comment] = [28, 30, 32].map(|at| u16_at(entry, at).map(usize::from));
        let (name, extra) = (46..46 + name?, 46 + name?..46 + name? + extra?);
        let end = extra.end + comment?;
        let mut wide = wide_numbers(entry.get(extra)?);
        let mut number = |at| {
            let narrow = u32_at(entry, at)?;
            let number = if narrow == u32::MAX { wide.next()? } else { u64::from(narrow) };
            usize::try_from(number).ok()
        };
        let (length, packed, header) = (number(24)?, number(20)?, number(42)?);
        let member = Self {
            name: String::from_utf8_lossy(entry.get(name)?).into_owned(),
            method: u16_at(entry, 10)?,
            is_encrypted: u16_at(entry, 8)? & 1 == 1,
            checksum: u32_at(entry, 16)?,
            packed,
            length,
            header,
        };
        Some((member, end))
    }

    /// Its bytes, unpacked.
    #[cfg(feature = "zarr")]
    pub fn length(&self) -> usize {
        if self.method == 0 { self.packed } else { self.length }
    }

    /// The first `count` bytes at most, for a look at its header.
    ///
    /// # Errors
    /// Those of [`Self::bytes`].
    pub fn beginning(&self, source: &Source, count: usize) -> Result<Vec<u8>> {
        let (data, _) = self.data(source)?;
        Ok(match self.method {
            0 => data[..data.len().min(count)].to_vec(),
            _ => beginning(data, Compression::Deflate, count.min(self.length)),
        })
    }

    /// Whether it is stored as it is, without compression.
    pub fn is_stored(&self) -> bool {
        self.method == 0
    }

    /// Bytes that hold the member, and where it begins. Stored ones stay mapped.
    ///
    /// # Errors
    /// Encryption, compressions other than deflate, damaged data.
    pub fn bytes(&self, source: &Source) -> Result<(VoxelBytes, usize)> {
        let (data, start) = self.data(source)?;
        if self.is_stored() {
            return Ok((source.shared(), start));
        }
        Ok((Arc::new(self.inflated(source, data)?), 0))
    }

    /// The member unpacked from `data`, its deflated bytes.
    ///
    /// # Errors
    /// Damaged data, too little memory.
    pub fn inflated(&self, source: &Source, data: &[u8]) -> Result<Vec<u8>> {
        let unpacked = decompress(source, data, Compression::Deflate, self.length)?;
        let mut crc = Crc::new();
        crc.update(&unpacked);
        if crc.sum() != self.checksum {
            return Err(source.malformed(format!(
                "`{}` in it does not have its checksum; copy or download the file again",
                self.name
            )));
        }
        Ok(unpacked)
    }

    /// Packed bytes of the member, and where they begin in the archive.
    fn data<'a>(&self, source: &'a Source) -> Result<(&'a [u8], usize)> {
        self.check_packing(source)?;
        let bytes = source.bytes();
        let local = bytes.get(self.header..).and_then(data_after);
        let start = local.map(|after| self.header + after);
        let data = start.and_then(|start| Some((bytes.get(start..start.checked_add(self.packed)?)?, start)));
        data.ok_or_else(|| self.cut_short(source))
    }

    /// Checks that the member can be unpacked.
    ///
    /// # Errors
    /// Encryption, compressions other than deflate.
    pub fn check_packing(&self, source: &Source) -> Result<()> {
        if self.is_encrypted || !matches!(self.method, 0 | 8) {
            return Err(source.unsupported(format!(
                "`{}` in it is encrypted or packed by a method that is not read; pack it with deflate or not at all",
                self.name
            )));
        }
        Ok(())
    }

    /// The error for a member that ends early, or whose header is damaged.
    pub fn cut_short(&self, source: &Source) -> Error {
        source.malformed(format!("`{}` in it is cut short; copy or download the file again", self.name))
    }
}

/// Bytes of a local header without its name and extra fields.
pub const HEADER: usize = 30;

/// Bytes from the beginning of the local header that begins `bytes` to the data behind it; none if it is damaged.
pub fn data_after(bytes: &[u8]) -> Option<usize> {
    let [name, extra] = [26, 28].map(|at| u16_at(bytes, at).map(usize::from));
    let length = HEADER + name? + extra?;
    bytes.starts_with(b"PK\x03\x04").then_some(length)
}

/// The 64-bit numbers of a zip64 field in the `extra` fields of an entry.
fn wide_numbers(mut extra: &[u8]) -> impl Iterator<Item = u64> + use<'_> {
    let mut field: &[u8] = &[];
    while let (Some(id), Some(length)) = (u16_at(extra, 0), u16_at(extra, 2)) {
        let Some(content) = extra.get(4..4 + usize::from(length)) else { break };
        if id == 1 {
            field = content;
        }
        extra = &extra[4 + usize::from(length)..];
    }
    field.as_chunks().0.iter().map(|number| u64::from_le_bytes(*number))
}

fn u16_at(bytes: &[u8], at: usize) -> Option<u16> {
    bytes.get(at..)?.first_chunk().map(|number| u16::from_le_bytes(*number))
}

fn u32_at(bytes: &[u8], at: usize) -> Option<u32> {
    bytes.get(at..)?.first_chunk().map(|number| u32::from_le_bytes(*number))
}

fn u64_at(bytes: &[u8], at: usize) -> Option<u64> {
    bytes.get(at..)?.first_chunk().map(|number| u64::from_le_bytes(*number))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The last bytes of an archive of one member, whose directory begins at `start` by the record of zip64 at `record`.
    fn tail(start: u64, record: u64) -> Vec<u8> {
        let wide =
            [&b"PK\x06\x06"[..], &[0; 28], &1u64.to_le_bytes(), &[0; 8], &start.to_le_bytes()].concat();
        let locator = [&b"PK\x06\x07"[..], &[0; 4], &record.to_le_bytes(), &[0; 4]].concat();
        let end = [&b"PK\x05\x06"[..], &[0xFF; 16], &[3, 0], b"end"].concat();
        [wide, locator, end].concat()
    }

    #[test]
    fn directories_are_found_from_the_last_bytes() {
        let found = |tail: &[u8], from| Directory::find(tail, from).map(|found| (found.start, found.count));
        assert_eq!(found(&tail(700, 1 << 33), 1 << 33), Some((700, 1)));
        // The record lies before these bytes, behind them, or is none.
        for record in [999, 5000, u64::MAX, 1001] {
            assert!(found(&tail(700, record), 1000).is_none_or(|(start, _)| start != 700), "{record}");
        }
        let narrow =
            [&b"PK\x05\x06"[..], &[0; 4], &[0; 2], &[2, 0], &[0; 4], &[9, 0, 0, 0], &[0; 2]].concat();
        assert_eq!(found(&narrow, 1 << 40), Some((9, 2)));
        assert_eq!(found(b"PK\x05\x06", 0), None);
    }
}
