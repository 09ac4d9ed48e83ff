//! Filters of HDF5 that others have registered: LZ4 and Blosc.

use super::limits::{BYTES_PER_BYTE, FREE_BYTES};
use crate::volume::blosc;
use hdf5_reader::error::{Error, Result};

/// Numbers under which the filters are registered.
pub const BLOSC: u16 = 32001;
pub const LZ4: u16 = 32004;

/// Unpacks a chunk of Blosc.
///
/// # Errors
/// Damaged data, a codec that is not read.
pub fn of_blosc(data: &[u8]) -> Result<Vec<u8>> {
    let most = data.len().saturating_mul(BYTES_PER_BYTE).saturating_add(FREE_BYTES);
    blosc::unpacked(data, most).map_err(|problem| match problem {
        blosc::Problem::Damaged => Error::DecompressionError("Blosc: a chunk is damaged".into()),
        blosc::Problem::Codec(name) => Error::UnsupportedFilter(format!("Blosc with {name}")),
    })
}

/// Unpacks blocks of LZ4: the length of all, the length of one, and each with its packed length. Numbers are big-endian.
///
/// # Errors
/// Damaged data.
pub fn of_lz4(data: &[u8]) -> Result<Vec<u8>> {
    blocks(data).ok_or_else(|| Error::DecompressionError("LZ4: a chunk is damaged".into()))
}

fn blocks(data: &[u8]) -> Option<Vec<u8>> {
    let (length, rest) = data.split_first_chunk()?;
    let length = usize::try_from(u64::from_be_bytes(*length)).ok()?;
    let (block, mut rest) = rest.split_first_chunk()?;
    let block = u32::from_be_bytes(*block) as usize;
    // One byte of LZ4 stands for 255 at most.
    if length > data.len().saturating_mul(255) {
        return None;
    }
    let mut out = vec![0; length];
    for unpacked in out.chunks_mut(block.max(1)) {
        let (packed, following) = rest.split_first_chunk()?;
        let (packed, following) = following.split_at_checked(u32::from_be_bytes(*packed) as usize)?;
        // What does not shrink is stored.
        if packed.len() == unpacked.len() {
            unpacked.copy_from_slice(packed);
        } else if lz4_flex::block::decompress_into(packed, unpacked).ok()? != unpacked.len() {
            return None;
        }
        rest = following;
    }
    Some(out)
}
