//! The index of a shard: where its chunks are.

use super::{Scratch, Shards};
use crate::volume::zarr::store::Blob;
use fovol_core::Endian;
use std::ops::Range;

/// Bytes of an entry: offset and length.
const ENTRY: usize = 16;

/// Where each chunk of a shard is, in C order; none for chunks that are not stored.
pub type Places = Vec<Option<Range<usize>>>;

impl Shards {
    /// Reads the index of `shard`. It is never longer than the shard.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn places(&self, shard: &dyn Blob) -> Result<Places, String> {
        let cut = || format!("a shard of {} bytes is cut short", shard.length());
        let count = self.counts.iter().try_fold(ENTRY, |bytes, &count| bytes.checked_mul(count));
        let length = count.ok_or_else(cut)?;
        let stored = self.index.fixed_length(length).filter(|&stored| stored <= shard.length());
        let stored = stored.ok_or_else(cut)?;
        let start = if self.is_index_first { 0 } else { shard.length() - stored };
        let (mut buffer, mut scratch) = (Vec::new(), Scratch::default());
        let bytes = shard.part(start..start + stored, &mut buffer).map_err(|e| e.to_string())?;
        let index = self.index.decode(bytes, length, &mut scratch);
        let index = index.map_err(|problem| format!("the index of a shard is damaged: {problem}"))?;
        let number = |bytes: &[u8; 8]| match self.index_endian {
            Endian::Little => u64::from_le_bytes(*bytes),
            Endian::Big => u64::from_be_bytes(*bytes),
        };
        let place = |[offset, length]: &[[u8; 8]; 2]| match (number(offset), number(length)) {
            (u64::MAX, u64::MAX) => Ok(None),
            (offset, length) => {
                let end = offset.checked_add(length).filter(|&end| end <= shard.length() as u64);
                end.map(|end| Some(offset as usize..end as usize)).ok_or_else(cut)
            }
        };
        index.as_chunks::<8>().0.as_chunks::<2>().0.iter().map(place).collect()
    }
}
