//! The bytes of an array: lengths first, then values, raw or in compressed blocks.

use super::base64::Base64;
use super::document::{Appended, Coding, Compressor};
use crate::Result;
use crate::volume::Source;
use crate::volume::decompress::{Compression, decompress, read_exactly};
use fovol_core::{Voxel, VoxelBytes};
use std::io::Read;
use std::sync::Arc;

/// The first `needed` bytes of the array that is written as base64 in `text`.
///
/// # Errors
/// Damaged or missing data.
pub fn inline(source: &Source, coding: Coding, text: &str, needed: usize) -> Result<Vec<u8>> {
    Stream::base64(source, coding, text.as_bytes()).values(needed)
}

/// Bytes that hold the first `needed` bytes of the array that begins `offset` after the mark of the appended
/// data, and where they begin. Bare values stay mapped.
///
/// # Errors
/// Damaged or missing data.
pub fn appended(
    source: &Source,
    coding: Coding,
    appended: Appended,
    offset: usize,
    needed: usize,
) -> Result<(VoxelBytes, usize)> {
    let start = appended.start.checked_add(offset).filter(|&start| start <= source.bytes().len());
    let start = start.ok_or_else(|| {
        source.malformed(format!("an array begins {offset} bytes into its appended data, beyond its end"))
    })?;
    let data = &source.bytes()[start..];
    if appended.is_base64 {
        return Ok((Arc::new(Stream::base64(source, coding, data).values(needed)?), 0));
    }
    let mut stream = Stream { source, coding, available: data.len(), reader: Box::new(data) };
    if coding.compressor.is_some() {
        return Ok((Arc::new(stream.values(needed)?), 0));
    }
    stream.expect(needed)?;
    let first = start + coding.word();
    if needed > source.bytes().len() - first {
        let found = source.bytes().len() - first;
        return Err(source.malformed(format!(
            "it ends after {found} of {needed} bytes of values; copy or download it again"
        )));
    }
    Ok((source.shared(), first))
}

impl Coding {
    /// The bytes of one length.
    fn word(self) -> usize {
        if self.is_wide { 8 } else { 4 }
    }
}

/// The bytes of one array, as they come.
struct Stream<'a> {
    source: &'a Source,
    coding: Coding,
    /// No more bytes than this can come.
    available: usize,
    reader: Box<dyn Read + 'a>,
}

impl<'a> Stream<'a> {
    fn base64(source: &'a Source, coding: Coding, text: &'a [u8]) -> Self {
        Self { source, coding, available: text.len() / 4 * 3 + 3, reader: Box::new(Base64::new(text)) }
    }

    fn values(&mut self, needed: usize) -> Result<Vec<u8>> {
        match self.coding.compressor {
            Some(compressor) => self.blocks(compressor, needed),
            None => {
                self.expect(needed)?;
                self.bytes(needed)
            }
        }
    }

    /// Reads the length of uncompressed values, of which `needed` are wanted.
    fn expect(&mut self, needed: usize) -> Result<()> {
        let length = self.length()?;
        match length < needed {
            true => Err(self.source.malformed(format!(
                "its array has {length} bytes, but its extent and type need {needed}; do they belong together?"
            ))),
            false => Ok(()),
        }
    }

    /// Reads compressed blocks: their number, their size, the size of the last one, their compressed sizes.
    fn blocks(&mut self, compressor: Compressor, needed: usize) -> Result<Vec<u8>> {
        let (count, size, last) = (self.length()?, self.length()?, self.length()?);
        if count > self.available / self.coding.word() {
            return Err(self.source.malformed(format!("its array cannot have {count} compressed blocks")));
        }
        let packed: Vec<usize> = (0..count).map(|_| self.length()).collect::<Result<_>>()?;
        let mut out = Vec::new();
        for (i, packed) in packed.into_iter().enumerate() {
            let missing = needed - out.len();
            if missing == 0 {
                break;
            }
            let size = if i + 1 == count && last != 0 { last } else { size };
            let block = self.bytes(packed)?;
            out.append(&mut match compressor {
                Compressor::Zlib => decompress(self.source, &block, Compression::Zlib, size.min(missing))?,
                Compressor::Lz4 => lz4(self.source, &block, size, missing)?,
            });
        }
        match out.len() < needed {
            true => Err(self.source.malformed(format!(
                "its array has {} bytes, but its extent and type need {needed}; do they belong together?",
                out.len()
            ))),
            false => Ok(out),
        }
    }

    fn length(&mut self) -> Result<usize> {
        let word = self.coding.word();
        let bytes = self.bytes(word)?;
        let length = match self.coding.is_wide {
            true => u64::decode(&bytes, self.coding.endian),
            false => u64::from(u32::decode(&bytes, self.coding.endian)),
        };
        usize::try_from(length)
            .map_err(|_| self.source.malformed("an array in it is longer than this machine can address"))
    }

    fn bytes(&mut self, count: usize) -> Result<Vec<u8>> {
        if count > self.available {
            return Err(self.source.malformed(format!(
                "an array in it wants {count} bytes where at most {} follow; copy or download it again",
                self.available
            )));
        }
        self.available -= count;
        read_exactly(self.source, &mut *self.reader, count)
    }
}

/// The first `wanted` bytes of a block of `size`.
fn lz4(source: &Source, packed: &[u8], size: usize, wanted: usize) -> Result<Vec<u8>> {
    let damaged = || source.malformed("an LZ4 block in it is damaged; copy or download it again");
    // One byte of LZ4 stands for 255 at most.
    if size > packed.len().saturating_mul(255) {
        return Err(damaged());
    }
    let mut out = lz4_flex::block::decompress(packed, size).map_err(|_| damaged())?;
    if out.len() != size {
        return Err(damaged());
    }
    out.truncate(wanted);
    Ok(out)
}
