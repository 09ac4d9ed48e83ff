//! Words that begin where a line of the processor's caches begins: what is read 64 bytes at a time lies in one line then,
//! not in two.

use bytemuck::{Pod, Zeroable, cast_slice, cast_slice_mut};
use std::ops::{Deref, DerefMut};

/// Words of a line.
pub const WORDS_OF_LINE: usize = 16;

/// Has the processor load the line of number `at`, which may lie beyond the end of `numbers`, while it does something else.
#[inline(always)]
pub fn prefetch<N>(numbers: &[N], at: usize) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        // SAFETY: this instruction changes nothing that a program sees, and no address is wrong for it.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(numbers.as_ptr().wrapping_add(at).cast()) };
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (numbers, at);
}

#[derive(Debug, Clone, Copy, Default, Pod, Zeroable)]
#[repr(C, align(64))]
struct Line([u32; WORDS_OF_LINE]);

/// As a `Vec<u32>`, at a line's beginning.
#[derive(Debug, Clone, Default)]
pub struct Lines {
    lines: Vec<Line>,
    length: usize,
}

impl Lines {
    /// Has `length` words from now on; those that are new are zeros or anything that was there before.
    pub fn resize(&mut self, length: usize) {
        let lines = length.div_ceil(WORDS_OF_LINE);
        if self.lines.len() < lines {
            self.lines.resize(lines, Line::default());
        }
        self.length = length;
    }

    /// Memory for `length` numbers, which may be anything.
    #[inline(always)]
    pub fn numbers<N: Pod>(&mut self, length: usize) -> &mut [N] {
        self.resize((length * size_of::<N>()).div_ceil(size_of::<u32>()));
        &mut cast_slice_mut(self)[..length]
    }
}

impl Deref for Lines {
    type Target = [u32];

    #[inline(always)]
    fn deref(&self) -> &[u32] {
        &cast_slice(&self.lines)[..self.length]
    }
}

impl DerefMut for Lines {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [u32] {
        &mut cast_slice_mut(&mut self.lines)[..self.length]
    }
}

impl From<Vec<u32>> for Lines {
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
        let mut lines = Lines::from((0..35).collect::<Vec<u32>>());
        assert_eq!((lines.len(), lines[34]), (35, 34));
        assert!(lines.as_ptr().cast::<Line>().is_aligned());
        lines.resize(3);
        assert_eq!(lines[..], [0, 1, 2]);
    }
}
