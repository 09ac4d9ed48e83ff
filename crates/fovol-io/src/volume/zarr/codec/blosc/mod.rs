//! Blosc: blocks of shuffled bytes, each packed on its own.
//! <https://github.com/Blosc/c-blosc/blob/main/README_CHUNK_FORMAT.rst>.
//!
//! It is read here because the library in C also builds Snappy, which needs a C++ compiler.

mod blosclz;
mod shuffle;

pub use shuffle::unshuffle;
use shuffle::unshuffle_bits;
use std::cell::RefCell;
use std::io::Read;

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
pub fn decode(packed: &[u8], out: &mut Vec<u8>, most: usize) -> Result<(), String> {
    let header = Header::parse(packed).ok_or("its first bytes are no Blosc")?;
    if header.length > most {
        return Err(format!("it has {} bytes", header.length));
    }
    if out.len() < header.length {
        out.clear();
    }
    out.resize(header.length, 0);
    if header.flags & STORED != 0 {
        let stored = packed.get(HEADER..HEADER + header.length).ok_or("it is cut short")?;
        out.copy_from_slice(stored);
        return Ok(());
    }
    BLOCK.with_borrow_mut(|scratch| {
        for (number, block) in out.chunks_mut(header.block).enumerate() {
            let at = packed.get(HEADER + 4 * number..).and_then(<[u8]>::first_chunk);
            let at = at.map(|at| u32::from_le_bytes(*at) as usize);
            let streams = at.and_then(|at| packed.get(at..)).ok_or("it is cut short")?;
            decode_block(&header, streams, block, scratch)?;
        }
        Ok(())
    })
}

/// Unpacks the block that begins `packed` to `out`.
fn decode_block(header: &Header, packed: &[u8], out: &mut [u8], scratch: &mut Vec<u8>) -> Result<(), String> {
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
fn decode_streams(header: &Header, mut packed: &[u8], out: &mut [u8]) -> Result<(), String> {
    let Header { flags, size, block, .. } = *header;
    let is_split = flags & WHOLE_BLOCKS == 0
        && size <= LARGEST_SPLIT
        && block / size >= SMALLEST_SPLIT
        && out.len() == block;
    let streams = if is_split { size } else { 1 };
    if !out.len().is_multiple_of(streams) {
        return Err("its blocks do not divide".into());
    }
    let each = out.len() / streams;
    for stream in out.chunks_exact_mut(each.max(1)) {
        let (length, rest) = packed.split_first_chunk().ok_or("it is cut short")?;
        let length = u32::from_le_bytes(*length) as usize;
        let (bytes, rest) = rest.split_at_checked(length).ok_or("it is cut short")?;
        if length == stream.len() {
            stream.copy_from_slice(bytes);
        } else if decode_stream(flags >> 5, bytes, stream)? != stream.len() {
            return Err("a block is too short".into());
        }
        packed = rest;
    }
    Ok(())
}

/// Unpacks one stream, and returns its length.
fn decode_stream(compressor: u8, packed: &[u8], out: &mut [u8]) -> Result<usize, String> {
    match compressor {
        0 => blosclz::decode(packed, out).ok_or_else(|| "a block of blosclz is damaged".into()),
        1 => lz4_flex::block::decompress_into(packed, out).map_err(|e| e.to_string()),
        3 => {
            let read = flate2::bufread::ZlibDecoder::new(packed).read_exact(out);
            read.map(|()| out.len()).map_err(|e| e.to_string())
        }
        4 => zstd_safe::decompress(out, packed).map_err(|code| zstd_safe::get_error_name(code).to_owned()),
        2 => Err("it uses Snappy, which is not read; write it with zstd or lz4".into()),
        other => Err(format!("it uses a compressor of number {other}, which is not known")),
    }
}
