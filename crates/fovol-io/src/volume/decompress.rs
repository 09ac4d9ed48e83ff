use super::source::Source;
use crate::{Error, Result};
use fovol_core::memory::{self, Estimate, Shortage};
use fovol_core::stop;
use std::io::{self, Read};

/// The compressions that volume files use.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Compression {
    /// gzip, several members too.
    Gzip,
    /// A zlib stream without a container.
    Zlib,
    /// A deflate stream alone, as zip archives have it.
    Deflate,
    /// bzip2, several streams too.
    Bzip2,
}

/// The first piece of memory that is asked for. A small file cannot make us ask for much.
const FIRST_PIECE: usize = 64 << 10;

/// The largest piece: from here on memory grows evenly, so that little more is held than is needed.
const LARGEST_PIECE: usize = 16 << 20;

/// Advice for compressed files that do not fit in memory.
const UNPACK: &str = "unpacked, as .nhdr or .raw, it needs no memory until it is rendered; `fovolnet convert` unpacks it where there is more";

/// Decompresses `bytes` of `source` until `needed` bytes are there.
///
/// Memory grows with the output, and a decompression bomb is read no further than `needed`.
///
/// # Errors
/// A stream that is damaged or ends before `needed` bytes.
pub fn decompress(source: &Source, bytes: &[u8], compression: Compression, needed: usize) -> Result<Vec<u8>> {
    let mut reader = reader(bytes, compression);
    read_exactly(source, &mut reader, needed)
}

/// Reads `needed` bytes, growing with what really comes.
///
/// # Errors
/// A stream that fails or ends early; no memory for what comes.
pub fn read_exactly(source: &Source, reader: &mut dyn Read, needed: usize) -> Result<Vec<u8>> {
    let scarce = |shortage: Shortage| Error::memory(source.path(), shortage);
    let mut out = Vec::new();
    let mut estimated = LARGEST_PIECE;
    while out.len() < needed {
        let before = out.len();
        if before >= estimated {
            // What has come speaks for some more, not for whatever a header promises.
            let likely = (needed - before).min(16 * before);
            let rest = Estimate::new("unpacking it").with("the next voxels", likely as u64);
            rest.check(UNPACK).map_err(scarce)?;
            estimated = 2 * before;
        }
        let more = (needed - before).min(before.clamp(FIRST_PIECE, LARGEST_PIECE));
        memory::reserve(&mut out, more, "unpacking it", UNPACK).map_err(scarce)?;
        out.resize(before + more, 0);
        reader.read_exact(&mut out[before..]).map_err(|e| {
            source.malformed(format!(
                "its compressed data is damaged or ends before the {needed} bytes that its voxels need ({e}); copy or download the file again"
            ))
        })?;
    }
    Ok(out)
}

/// Decompresses the first `length` bytes from `bytes`; fewer if the stream ends or is damaged.
pub fn beginning(bytes: &[u8], compression: Compression, length: usize) -> Vec<u8> {
    let mut out = Vec::new();
    // What came before the damage is still the beginning.
    let _ = reader(bytes, compression).take(length as u64).read_to_end(&mut out);
    out
}

fn reader(bytes: &[u8], compression: Compression) -> Watchful<Box<dyn Read + '_>> {
    Watchful(match compression {
        Compression::Gzip => Box::new(flate2::bufread::MultiGzDecoder::new(bytes)),
        Compression::Zlib => Box::new(flate2::bufread::ZlibDecoder::new(bytes)),
        Compression::Deflate => Box::new(flate2::bufread::DeflateDecoder::new(bytes)),
        Compression::Bzip2 => Box::new(bzip2::bufread::MultiBzDecoder::new(bytes)),
    })
}

/// Looks at every read whether it is to stop.
struct Watchful<R>(R);

impl<R: Read> Read for Watchful<R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        stop::point();
        // Decoders fill all that they are given, however much that is.
        let most = out.len().min(FIRST_PIECE);
        self.0.read(&mut out[..most])
    }
}

/// Decompresses everything in `bytes`, up to `limit` bytes.
///
/// # Errors
/// A damaged stream, or more than `limit` bytes; no memory for what comes.
pub fn decompress_all(
    source: &Source,
    bytes: &[u8],
    compression: Compression,
    limit: usize,
) -> Result<Vec<u8>> {
    let mut reader = reader(bytes, compression).take(limit as u64 + 1);
    let mut out = Vec::new();
    loop {
        let before = out.len();
        let more = before.clamp(FIRST_PIECE, LARGEST_PIECE);
        memory::reserve(&mut out, more, "unpacking it", UNPACK)
            .map_err(|shortage| Error::memory(source.path(), shortage))?;
        // No more than there is room for, so that `out` never grows by itself.
        let read = reader.by_ref().take(more as u64).read_to_end(&mut out);
        let read = read.map_err(|e| {
            source.malformed(format!("its compressed data is damaged ({e}); copy or download the file again"))
        })?;
        if read < more {
            break;
        }
    }
    if out.len() > limit {
        return Err(source.malformed(format!("it decompresses to more than {limit} bytes; is it a volume?")));
    }
    Ok(out)
}

/// Counts the bytes that `bytes` decompress to, without storing them.
///
/// None if the stream is damaged or decompresses to more than `limit` bytes.
pub fn decompressed_length(bytes: &[u8], compression: Compression, limit: usize) -> Option<usize> {
    let mut reader = reader(bytes, compression).take(limit as u64 + 1);
    let length = io::copy(&mut reader, &mut io::sink()).ok()?;
    usize::try_from(length).ok().filter(|&length| length <= limit)
}
