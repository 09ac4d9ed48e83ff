//! Arrays of words aligned to cache lines, so that a read of 64 bytes touches one line instead of two.

use bytemuck::{Pod, Zeroable, cast_slice, cast_slice_mut};
use std::ops::{Deref, DerefMut};

/// Number of words in a cache line.
pub const WORDS_OF_LINE: usize = 16;

#[derive(Debug, Clone, Copy, Default, Pod, Zeroable)]
#[repr(C, align(64))]
struct Line([u32; WORDS_OF_LINE]);

/// Growable array of words, aligned to cache lines.
#[derive(Debug, Clone, Default)]
pub struct AlignedBuf {
    lines: Vec<Line>,
    length: usize,
}

impl AlignedBuf {
    /// Sets the length. New words are undefined: zeros, or words from earlier use.
    pub fn resize(&mut self, length: usize) {
        let lines = length.div_ceil(WORDS_OF_LINE);
        if self.lines.len() < lines {
            self.lines.resize(lines, Line::default());
        }
        self.length = length;
    }

    /// Returns scratch memory for `length` elements, with undefined contents.
    #[inline(always)]
    pub fn numbers<N: Pod>(&mut self, length: usize) -> &mut [N] {
        self.resize((length * size_of::<N>()).div_ceil(size_of::<u32>()));
        &mut cast_slice_mut(self)[..length]
    }
}

impl Deref for AlignedBuf {
    type Target = [u32];

    #[inline(always)]
    fn deref(&self) -> &[u32] {
        &cast_slice(&self.lines)[..self.length]
    }
}

impl DerefMut for AlignedBuf {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [u32] {
        &mut cast_slice_mut(&mut self.lines)[..self.length]
    }
}

impl From<Vec<u32>> for AlignedBuf {
    fn from(words: Vec<u32>) -> Self {
        let mut lines = Self::default();
        lines.resize(words.len());
        lines.copy_from_slice(&words);
        lines
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_begin_with_a_line() {
        let mut lines = AlignedBuf::from((0..35).collect::<Vec<u32>>());
        assert_eq!((lines.len(), lines[34]), (35, 34));
        assert!(lines.as_ptr().cast::<Line>().is_aligned());
        lines.resize(3);
        assert_eq!(lines[..], [0, 1, 2]);
    }
}
