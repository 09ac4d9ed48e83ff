//! Chunks that Blosc packed, version 1: <https://github.com/Blosc/c-blosc/blob/main/README_CHUNK_FORMAT.rst>.
//!
//! A chunk is cut into blocks. The bytes of a block are shuffled, so that like bytes of its values stand together, and
//! packed by one of several codecs, as one stream or as one for each byte of a value.

mod blosclz;
mod shuffle;

use flate2::read::ZlibDecoder;
use shuffle::Shuffle;
use std::fmt;
use std::io::Read;

/// Bytes before the places of the blocks.
const HEADER: usize = 16;

/// Values of more bytes are never split into streams.
const MOST_STREAMS: usize = 16;

/// Streams of fewer bytes are never split off.
const SHORTEST_STREAM: usize = 128;

/// Bytes that one packed byte stands for at most, by the best of the codecs.
const BYTES_PER_BYTE: usize = 1032;

/// Why a chunk cannot be unpacked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Problem {
    /// It is cut short or changed.
    Damaged,
    /// It is packed by a codec that is not read.
    Codec(&'static str),
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Damaged => write!(f, "damaged"),
            Self::Codec(name) => write!(f, "packed with {name}"),
        }
    }
}

/// The codecs that are read.
#[derive(Debug, Clone, Copy)]
enum Codec {
    BloscLz,
    Lz4,
    Zlib,
}

/// The header of a chunk.
struct Chunk<'a> {
    bytes: &'a [u8],
    codec: Codec,
    shuffle: Shuffle,
    /// Bytes of one value.
    size: usize,
    /// Bytes of the unpacked chunk.
    length: usize,
    /// Bytes of every unpacked block but the last.
    block: usize,
    may_split: bool,
}

/// Unpacks the chunk `bytes`, which may be `most` bytes long at most when unpacked. Bytes after the chunk are left alone.
///
/// # Errors
/// Damage, a codec that is not read, more than `most` bytes.
pub fn unpacked(bytes: &[u8], most: usize) -> Result<Vec<u8>, Problem> {
    let (flags, size) = match bytes {
        [_, _, flags, size, ..] => (*flags, usize::from(*size)),
        _ => return Err(Problem::Damaged),
    };
    let [length, block, packed] = [4, 8, 12].map(|at| number(bytes, at));
    let (length, block, packed) = (length?, block?, packed?);
    let bytes = bytes.get(..packed).filter(|_| packed >= HEADER).ok_or(Problem::Damaged)?;
    if length > most || length > packed.saturating_mul(BYTES_PER_BYTE) {
        return Err(Problem::Damaged);
    }
    if flags & 2 != 0 {
        return bytes.get(HEADER..HEADER + length).map(<[u8]>::to_vec).ok_or(Problem::Damaged);
    }
    let codec = match flags >> 5 {
        0 => Codec::BloscLz,
        1 => Codec::Lz4,
        2 => return Err(Problem::Codec("Snappy")),
        3 => Codec::Zlib,
        4 => return Err(Problem::Codec("Zstandard")),
        _ => return Err(Problem::Codec("a codec of its own")),
    };
    if length > 0 && (block == 0 || block > length || size == 0) {
        return Err(Problem::Damaged);
    }
    let chunk = Chunk {
        bytes,
        codec,
        shuffle: Shuffle::of(flags),
        size,
        length,
        block,
        may_split: flags & 0x10 == 0,
    };
    chunk.unpacked()
}

impl Chunk<'_> {
    fn unpacked(&self) -> Result<Vec<u8>, Problem> {
        let mut out = Vec::with_capacity(self.length);
        let mut streams = Vec::new();
        for index in 0..self.length.div_ceil(self.block.max(1)) {
            let length = self.block.min(self.length - out.len());
            let start = number(self.bytes, HEADER + 4 * index)?;
            streams.clear();
            self.add_block(start, length, &mut streams)?;
            self.shuffle.undo(self.size, &streams, &mut out);
        }
        Ok(out)
    }

    /// Appends the unpacked streams of the block of `length` bytes that is packed at `at`.
    fn add_block(&self, mut at: usize, length: usize, out: &mut Vec<u8>) -> Result<(), Problem> {
        let is_split = self.may_split
            && length == self.block
            && self.size <= MOST_STREAMS
            && length / self.size >= SHORTEST_STREAM;
        let count = if is_split { self.size } else { 1 };
        for _ in 0..count {
            let packed = number(self.bytes, at)?;
            let end = (at + 4).checked_add(packed).ok_or(Problem::Damaged)?;
            let stream = self.bytes.get(at + 4..end).ok_or(Problem::Damaged)?;
            self.add_stream(stream, length / count, out)?;
            at = end;
        }
        // A chunk whose block is no multiple of its values is none of Blosc's.
        if length.is_multiple_of(count) { Ok(()) } else { Err(Problem::Damaged) }
    }

    /// Appends the `length` bytes that `stream` unpacks to.
    fn add_stream(&self, stream: &[u8], length: usize, out: &mut Vec<u8>) -> Result<(), Problem> {
        // What does not shrink is stored.
        if stream.len() == length {
            out.extend_from_slice(stream);
            return Ok(());
        }
        let start = out.len();
        out.resize(start + length, 0);
        let unpacked = &mut out[start..];
        let written = match self.codec {
            Codec::BloscLz => blosclz::unpack(stream, unpacked),
            Codec::Lz4 => lz4_flex::block::decompress_into(stream, unpacked).ok(),
            Codec::Zlib => ZlibDecoder::new(stream).read_exact(unpacked).ok().map(|()| length),
        };
        if written == Some(length) { Ok(()) } else { Err(Problem::Damaged) }
    }
}

/// The 32-bit number at `at`.
fn number(bytes: &[u8], at: usize) -> Result<usize, Problem> {
    let number =
        bytes.get(at..).and_then(|rest| rest.first_chunk()).map(|number| i32::from_le_bytes(*number));
    number.and_then(|number| usize::try_from(number).ok()).ok_or(Problem::Damaged)
}

#[cfg(test)]
mod tests;
