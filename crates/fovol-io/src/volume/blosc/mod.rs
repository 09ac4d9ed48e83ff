//! Blosc: blocks of shuffled bytes, each packed on its own.
//! <https://github.com/Blosc/c-blosc/blob/main/README_CHUNK_FORMAT.rst>.
//!
//! It is read here because the library in C also builds Snappy, which needs a C++ compiler. Blocks of Zstandard need the cargo
//! feature `zarr`.

mod blosclz;
mod shuffle;

#[cfg(feature = "zarr")]
pub use shuffle::unshuffle;
#[cfg(not(feature = "zarr"))]
use shuffle::unshuffle;
use shuffle::unshuffle_bits;
use std::cell::RefCell;
use std::fmt;
use std::io::Read;

/// Bytes that one packed byte stands for at most, by the best of the codecs.
const BYTES_PER_BYTE: usize = 1 << 15;

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
            Self::Damaged => f.write_str("it is cut short or damaged"),
            Self::Codec(name) => {
                write!(f, "it is packed by {name}, which is not read; write it with zstd or lz4")
            }
        }
    }
}

/// Unpacks the chunk `packed`, which may be `most` bytes long at most when unpacked. Bytes after the chunk are left alone.
///
/// # Errors
/// Damage, a codec that is not read, more than `most` bytes.
pub fn unpacked(packed: &[u8], most: usize) -> Result<Vec<u8>, Problem> {
    let mut out = Vec::new();
    decode(packed, &mut out, most.min(packed.len().saturating_mul(BYTES_PER_BYTE)))?;
    Ok(out)
}

/// Bytes before the places of the blocks.
const HEADER: usize = 16;

/// Bits of the flags.
const SHUFFLED: u8 = 1;
const STORED: u8 = 2;
const BITS_SHUFFLED: u8 = 4;
const WHOLE_BLOCKS: u8 = 16;

/// Blocks are split by the bytes of their values up to this size of a value, from this many values on.
const LARGEST_SPLIT: usize = 16;
const SMALLEST_SPLIT: usize = 128;

/// Numbers of an unpacked chunk.
struct Header {
    flags: u8,
    /// Bytes of a value.
    size: usize,
    length: usize,
    block: usize,
}

impl Header {
    fn parse(packed: &[u8]) -> Option<Self> {
        let [version, _, flags, size, numbers @ ..] = packed.first_chunk::<HEADER>()?;
        let number = |at: usize| Some(u32::from_le_bytes(*numbers[at..].first_chunk()?) as usize);
        let (length, block, whole) = (number(0)?, number(4)?, number(8)?);
        let is_sound =
            (1..=2).contains(version) && *size > 0 && whole <= packed.len() && (block > 0 || length == 0);
        is_sound.then_some(Self { flags: *flags, size: usize::from(*size), length, block: block.max(1) })
    }
}

thread_local! {
    /// A block before its bytes are put in order.
    static BLOCK: RefCell<Vec<u8>> = const { RefCell::new(Vec::new()) };
}

/// Replaces `out` by the bytes that `packed` holds, `most` at the most.
///
/// # Errors
/// What is wrong with `packed`.
pub fn decode(packed: &[u8], out: &mut Vec<u8>, most: usize) -> Result<(), Problem> {
    let header = Header::parse(packed).ok_or(Problem::Damaged)?;
    if header.length > most {
        return Err(Problem::Damaged);
    }
    if out.len() < header.length {
        out.clear();
    }
    out.resize(header.length, 0);
    if header.flags & STORED != 0 {
        let stored = packed.get(HEADER..HEADER + header.length).ok_or(Problem::Damaged)?;
        out.copy_from_slice(stored);
        return Ok(());
    }
    BLOCK.with_borrow_mut(|scratch| {
        for (number, block) in out.chunks_mut(header.block).enumerate() {
            let at = packed.get(HEADER + 4 * number..).and_then(<[u8]>::first_chunk);
            let at = at.map(|at| u32::from_le_bytes(*at) as usize);
            let streams = at.and_then(|at| packed.get(at..)).ok_or(Problem::Damaged)?;
            decode_block(&header, streams, block, scratch)?;
        }
        Ok(())
    })
}

/// Unpacks the block that begins `packed` to `out`.
fn decode_block(
    header: &Header,
    packed: &[u8],
    out: &mut [u8],
    scratch: &mut Vec<u8>,
) -> Result<(), Problem> {
    let is_shuffled = header.flags & SHUFFLED != 0 && header.size > 1;
    let is_bit_shuffled = header.flags & BITS_SHUFFLED != 0 && out.len() >= header.size;
    if !is_shuffled && !is_bit_shuffled {
        return decode_streams(header, packed, out);
    }
    if scratch.len() < out.len() {
        scratch.resize(out.len(), 0);
    }
    let ordered = &mut scratch[..out.len()];
    decode_streams(header, packed, ordered)?;
    match is_shuffled {
        true => unshuffle(ordered, out, header.size),
        false => unshuffle_bits(ordered, out, header.size),
    }
    Ok(())
}

/// Unpacks the streams of a block, each of which has its length before it.
fn decode_streams(header: &Header, mut packed: &[u8], out: &mut [u8]) -> Result<(), Problem> {
    let Header { flags, size, block, .. } = *header;
    let is_split = flags & WHOLE_BLOCKS == 0
        && size <= LARGEST_SPLIT
        && block / size >= SMALLEST_SPLIT
        && out.len() == block;
    let streams = if is_split { size } else { 1 };
    if !out.len().is_multiple_of(streams) {
        return Err(Problem::Damaged);
    }
    let each = out.len() / streams;
    for stream in out.chunks_exact_mut(each.max(1)) {
        let (length, rest) = packed.split_first_chunk().ok_or(Problem::Damaged)?;
        let length = u32::from_le_bytes(*length) as usize;
        let (bytes, rest) = rest.split_at_checked(length).ok_or(Problem::Damaged)?;
        if length == stream.len() {
            stream.copy_from_slice(bytes);
        } else if decode_stream(flags >> 5, bytes, stream)? != stream.len() {
            return Err(Problem::Damaged);
        }
        packed = rest;
    }
    Ok(())
}

/// Unpacks one stream, and returns its length.
fn decode_stream(compressor: u8, packed: &[u8], out: &mut [u8]) -> Result<usize, Problem> {
    let written = match compressor {
        0 => blosclz::decode(packed, out),
        1 => lz4_flex::block::decompress_into(packed, out).ok(),
        2 => return Err(Problem::Codec("Snappy")),
        3 => flate2::bufread::ZlibDecoder::new(packed).read_exact(out).ok().map(|()| out.len()),
        #[cfg(feature = "zarr")]
        4 => zstd_safe::decompress(out, packed).ok(),
        #[cfg(not(feature = "zarr"))]
        4 => return Err(Problem::Codec("Zstandard, without the cargo feature `zarr`")),
        _ => return Err(Problem::Codec("a codec of its own")),
    };
    written.ok_or(Problem::Damaged)
}

#[cfg(test)]
mod tests;
