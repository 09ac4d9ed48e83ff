//! Where the values of variables lie in a classic file: together, or one record after the other.

use super::header::{Header, Variable};
use crate::volume::Source;
use crate::{Error, Result};
use fovol_core::memory::{self, SMALLER_VOLUME};
use fovol_core::{Dtype, VoxelBytes, stop};
use std::sync::Arc;

/// The places of values in a file.
pub struct Records<'a> {
    source: &'a Source,
    header: &'a Header,
    /// Bytes from one record to the next.
    stride: usize,
    /// The number of records.
    pub count: usize,
}

impl<'a> Records<'a> {
    /// The places of all values in `source`; none if its sizes overflow.
    pub fn of(source: &'a Source, header: &'a Header) -> Option<Self> {
        let is_record = |variable: &&Variable| is_record(header, variable);
        let variables: Vec<&Variable> = header.variables.iter().filter(is_record).collect();
        let sizes: Option<Vec<usize>> = variables.iter().map(|variable| slice(header, variable)).collect();
        let stride = match *sizes?.as_slice() {
            // One variable alone is not filled up to four bytes.
            [size] => size,
            ref sizes => sizes
                .iter()
                .try_fold(0usize, |sum, size| sum.checked_add(size.checked_next_multiple_of(4)?))?,
        };
        let first = variables.iter().map(|variable| variable.begin).min().unwrap_or(0);
        let there = source.bytes().len().saturating_sub(first);
        // The last record may lack what fills it up.
        let most = if stride == 0 { 0 } else { there.div_ceil(stride) };
        let count = header.records.unwrap_or(most).min(most);
        Some(Self { source, header, stride, count })
    }

    /// Lengths of the axes of `variable`.
    pub fn shape(&self, variable: &Variable) -> Vec<usize> {
        let length = |&index: &usize| self.header.dimensions[index].length.unwrap_or(self.count);
        variable.dimensions.iter().map(length).collect()
    }

    /// The bytes of `variable`, and where they begin: all, or those at `index` of its first axis. They stay mapped where
    /// they lie together.
    ///
    /// # Errors
    /// A file that ends early, too little memory.
    pub fn bytes(&self, variable: &Variable, index: Option<usize>) -> Result<(VoxelBytes, usize)> {
        let short = || {
            let found = self.source.bytes().len();
            self.source.malformed(format!(
                "it ends after {found} bytes, before the last value of `{}`; copy or download it again",
                variable.name
            ))
        };
        let slice = slice(self.header, variable).ok_or_else(short)?;
        let is_record = is_record(self.header, variable);
        let step = if is_record { self.stride } else { slice };
        let count = match variable.dimensions.first() {
            Some(_) if index.is_some() => 1,
            Some(&first) => self.header.dimensions[first].length.unwrap_or(self.count),
            None => 1,
        };
        let from = index.unwrap_or(0).checked_mul(step).and_then(|offset| offset.checked_add(variable.begin));
        let last = count.saturating_sub(1).checked_mul(step).and_then(|offset| offset.checked_add(from?));
        let end = last.and_then(|last| last.checked_add(slice));
        let from =
            from.filter(|_| end.is_some_and(|end| end <= self.source.bytes().len())).ok_or_else(short)?;
        if step == slice || count == 1 {
            return Ok((self.source.shared(), from));
        }
        let mut out: Vec<u8> = Vec::new();
        memory::reserve(&mut out, slice * count, "gathering its records", SMALLER_VOLUME)
            .map_err(|shortage| Error::memory(self.source.path(), shortage))?;
        for record in 0..count {
            stop::point();
            out.extend_from_slice(&self.source.bytes()[from + record * step..][..slice]);
        }
        Ok((Arc::new(out), 0))
    }
}

/// Whether `variable` has one part in every record.
fn is_record(header: &Header, variable: &Variable) -> bool {
    variable.dimensions.first().is_some_and(|&first| header.dimensions[first].length.is_none())
}

/// Bytes of `variable` at one index of its first axis.
fn slice(header: &Header, variable: &Variable) -> Option<usize> {
    let size = variable.dtype.map_or(1, Dtype::size);
    let mut lengths =
        variable.dimensions.iter().skip(1).map(|&index| header.dimensions[index].length.unwrap_or(0));
    lengths.try_fold(size, usize::checked_mul)
}
