//! Compressions and checksums of bytes.

use super::crc32c;
use crate::volume::blosc;
use bzip2::bufread::MultiBzDecoder;
use flate2::bufread::{MultiGzDecoder, ZlibDecoder};
use serde_json::Value;
use std::io::Read;

/// A change of bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Compression {
    Zstd,
    Blosc,
    Gzip,
    Zlib,
    Bzip2,
    /// The length in four bytes, then a block.
    Lz4,
    /// Bytes of equal place in their values together; the size of a value.
    Shuffle(usize),
    /// Four bytes of a checksum, behind the bytes or before them.
    Checksum {
        kind: Checksum,
        is_behind: bool,
    },
}

/// Kinds of checksums.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Checksum {
    Crc32c,
    Crc32,
    Adler32,
    Fletcher32,
}

/// The most bytes that a byte stands for in blocks of Zstandard, and in deflate.
const MOST_OF_ZSTD: usize = 1 << 15;
const MOST_OF_DEFLATE: usize = 1032;
/// bzip2 packs zeros best, 45 MB into a thousand bytes.
const MOST_OF_BZIP2: usize = 1 << 16;

/// Bytes that any chunk may have.
const FREE: usize = 1 << 16;

impl Compression {
    /// The codec `name`.
    ///
    /// # Errors
    /// An unknown codec.
    pub fn of(name: &str, configuration: &Value) -> Result<Self, String> {
        let is_behind = match configuration.get("location").and_then(Value::as_str) {
            Some(location) => location == "end",
            None => name == "crc32c",
        };
        let checksum = |kind| Self::Checksum { kind, is_behind };
        Ok(match name {
            "zstd" => Self::Zstd,
            "blosc" => Self::Blosc,
            "gzip" => Self::Gzip,
            "zlib" => Self::Zlib,
            "bz2" => Self::Bzip2,
            "lz4" => Self::Lz4,
            "shuffle" => {
                let size = configuration.get("elementsize").and_then(Value::as_u64).unwrap_or(4);
                Self::Shuffle(usize::try_from(size).unwrap_or(0).max(1))
            }
            "crc32c" => checksum(Checksum::Crc32c),
            "crc32" => checksum(Checksum::Crc32),
            "adler32" => checksum(Checksum::Adler32),
            // It stands behind the bytes in both versions.
            "fletcher32" => Self::Checksum { kind: Checksum::Fletcher32, is_behind: true },
            _ => return Err(unknown(name)),
        })
    }

    /// Bytes that it adds to any bytes; none where that depends on them.
    pub fn added(self) -> Option<usize> {
        match self {
            Self::Checksum { .. } => Some(4),
            Self::Shuffle(_) => Some(0),
            _ => None,
        }
    }

    /// Replaces `out` by what `packed` was made from. Memory grows with what comes, and is refused for more than
    /// `most` bytes, or more than the compression can have packed.
    ///
    /// # Errors
    /// What is wrong with `packed`.
    pub fn decode(self, packed: &[u8], out: &mut Vec<u8>, most: usize) -> Result<(), String> {
        let limit = |ratio: usize| most.min(packed.len().saturating_mul(ratio).saturating_add(FREE));
        match self {
            Self::Zstd => zstd(packed, out, limit(MOST_OF_ZSTD)),
            Self::Blosc => {
                blosc::decode(packed, out, limit(MOST_OF_ZSTD)).map_err(|problem| problem.to_string())
            }
            Self::Gzip => stream(MultiGzDecoder::new(packed), out, limit(MOST_OF_DEFLATE)),
            Self::Zlib => stream(ZlibDecoder::new(packed), out, limit(MOST_OF_DEFLATE)),
            Self::Bzip2 => stream(MultiBzDecoder::new(packed), out, limit(MOST_OF_BZIP2)),
            Self::Lz4 => lz4(packed, out, limit(256)),
            Self::Shuffle(size) => {
                out.clear();
                out.resize(packed.len(), 0);
                blosc::unshuffle(packed, out, size);
                Ok(())
            }
            Self::Checksum { kind, is_behind } => checked(packed, out, kind, is_behind),
        }
    }
}

/// The problem with the codec `name`.
pub fn unknown(name: &str) -> String {
    format!("is packed by `{name}`, which is not read; write it with zstd, blosc, gzip or without a codec")
}

/// Reads all of `reader`, which gives `most` bytes at the most.
fn stream(reader: impl Read, out: &mut Vec<u8>, most: usize) -> Result<(), String> {
    out.clear();
    reader.take(most as u64 + 1).read_to_end(out).map_err(|e| e.to_string())?;
    if out.len() > most {
        return Err(format!("it has more than {most} bytes"));
    }
    Ok(())
}

fn zstd(packed: &[u8], out: &mut Vec<u8>, most: usize) -> Result<(), String> {
    let said = zstd_safe::get_frame_content_size(packed).map_err(|_| "its first bytes are no Zstandard")?;
    let length = match said {
        Some(length) if length > most as u64 => return Err(format!("it has {length} bytes")),
        // Frames may follow each other, and say nothing of their length.
        Some(length) if zstd_safe::find_frame_compressed_size(packed) == Ok(packed.len()) => length as usize,
        _ => most,
    };
    fit(out, length);
    let written = zstd_safe::decompress(&mut out[..], packed)
        .map_err(|code| zstd_safe::get_error_name(code).to_owned())?;
    out.truncate(written);
    Ok(())
}

fn lz4(packed: &[u8], out: &mut Vec<u8>, most: usize) -> Result<(), String> {
    let (length, block) = packed.split_first_chunk().ok_or("it is too short")?;
    let length = u32::from_le_bytes(*length) as usize;
    if length > most {
        return Err(format!("it has {length} bytes"));
    }
    fit(out, length);
    let written = lz4_flex::block::decompress_into(block, out).map_err(|e| e.to_string())?;
    out.truncate(written);
    Ok(())
}

/// Makes `out` `length` bytes long. What it holds does not matter.
pub fn fit(out: &mut Vec<u8>, length: usize) {
    if out.len() < length {
        out.clear();
    }
    out.resize(length, 0);
}

fn checked(packed: &[u8], out: &mut Vec<u8>, kind: Checksum, is_behind: bool) -> Result<(), String> {
    let parts = match is_behind {
        true => packed.split_last_chunk().map(|(bytes, sum)| (sum, bytes)),
        false => packed.split_first_chunk(),
    };
    let (sum, bytes) = parts.ok_or("it is too short")?;
    let found = match kind {
        Checksum::Crc32c => crc32c::sum(bytes),
        Checksum::Crc32 => {
            let mut crc = flate2::Crc::new();
            crc.update(bytes);
            crc.sum()
        }
        Checksum::Adler32 => adler32(bytes),
        Checksum::Fletcher32 => fletcher32(bytes),
    };
    if found != u32::from_le_bytes(*sum) {
        return Err("its checksum is another".into());
    }
    out.clear();
    out.extend_from_slice(bytes);
    Ok(())
}

fn adler32(bytes: &[u8]) -> u32 {
    const BASE: u32 = 65521;
    // The sums of so many bytes do not overflow.
    let [a, b] = bytes.chunks(5552).fold([1, 0], |[a, b], piece| {
        let [a, b] = piece.iter().fold([a, b], |[a, b], &byte| {
            let a: u32 = a + u32::from(byte);
            [a, b + a]
        });
        [a % BASE, b % BASE]
    });
    b << 16 | a
}

/// The checksum of HDF5, over pairs of bytes in big-endian order.
fn fletcher32(bytes: &[u8]) -> u32 {
    let fold = |sum: u32| (sum & 0xFFFF) + (sum >> 16);
    let (pairs, odd) = bytes.as_chunks::<2>();
    let mut sums = pairs.chunks(360).fold([0u32; 2], |sums, piece| {
        let sums = piece.iter().fold(sums, |[a, b], pair| {
            let a = a + u32::from(u16::from_be_bytes(*pair));
            [a, b + a]
        });
        sums.map(fold)
    });
    if let [last] = odd {
        sums[0] += u32::from(*last) << 8;
        sums[1] += sums[0];
        sums = sums.map(fold);
    }
    let [a, b] = sums.map(fold);
    b << 16 | a
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn checksums_are_those_of_their_definitions() {
        assert_eq!(adler32(b"Wikipedia"), 0x11E6_0398);
        assert_eq!(crc32c::sum(b"123456789"), 0xE306_9283);
    }

    #[test]
    fn more_than_can_be_packed_is_refused() {
        let mut out = Vec::new();
        let lz4 = [&(1u32 << 30).to_le_bytes()[..], &[0; 9]].concat();
        for (codec, packed) in
            [(Compression::Lz4, &lz4[..]), (Compression::Zstd, &[0x28, 0xB5, 0x2F, 0xFD][..])]
        {
            assert!(codec.decode(packed, &mut out, usize::MAX).is_err());
            assert!(out.capacity() < 1 << 20);
        }
    }
}
