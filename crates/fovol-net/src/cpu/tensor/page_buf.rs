//! Memory in words of 32 bits. Large buffers are mapped pages, on Linux huge pages if possible: networks touch so
//! much memory per frame that small pages would overflow the TLB.

use bytemuck::{cast_slice, cast_slice_mut};
use fovol_core::memory::{self, SMALLER_FRAMES, Shortage};
use memmap2::MmapMut;
use std::ops::{Deref, DerefMut};

/// Number of words from which buffers get pages of their own.
const LARGE: usize = 1 << 20;

/// Buffer of words, initially zero.
#[derive(Debug)]
pub struct PageBuf(Place);

#[derive(Debug)]
enum Place {
    Heap(Vec<u32>),
    Pages(MmapMut),
}

impl PageBuf {
    /// Allocates `count` words, all zero.
    pub fn zeros(count: usize) -> Self {
        Self::pages(count).unwrap_or_else(|| Self(Place::Heap(vec![0; count])))
    }

    /// `count` zeros.
    ///
    /// # Errors
    /// Too little memory.
    pub fn try_zeros(count: usize) -> Result<Self, Shortage> {
        let on_heap = || memory::zeroed(count, "the tensors of the network", SMALLER_FRAMES);
        Self::pages(count).map_or_else(|| on_heap().map(|words| Self(Place::Heap(words))), Ok)
    }

    /// `count` zeros on pages of their own. `None` if they are few, or the system has no pages.
    fn pages(count: usize) -> Option<Self> {
        let pages = (count >= LARGE).then(|| MmapMut::map_anon(count * size_of::<u32>()).ok()).flatten()?;
        // An error does no harm: ordinary pages work too.
        #[cfg(target_os = "linux")]
        let _ = pages.advise(memmap2::Advice::HugePage);
        Some(Self(Place::Pages(pages)))
    }
}

impl Default for PageBuf {
    fn default() -> Self {
        Self(Place::Heap(Vec::new()))
    }
}

impl Deref for PageBuf {
    type Target = [u32];

    #[inline(always)]
    fn deref(&self) -> &[u32] {
        match &self.0 {
            Place::Heap(words) => words,
            Place::Pages(pages) => cast_slice(pages),
        }
    }
}

impl DerefMut for PageBuf {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [u32] {
        match &mut self.0 {
            Place::Heap(words) => words,
            Place::Pages(pages) => cast_slice_mut(pages),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_and_many_words_are_zeros_that_can_be_written() {
        for count in [0, 3, LARGE + 5] {
            let mut words = PageBuf::zeros(count);
            assert_eq!(words.len(), count);
            assert!(words.iter().all(|&word| word == 0));
            if let Some(last) = words.last_mut() {
                *last = 7;
                assert_eq!(words[count - 1], 7);
            }
        }
    }
}
