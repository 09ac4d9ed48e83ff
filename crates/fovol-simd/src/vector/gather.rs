use super::arithmetic::MOST_LANES;
use super::integers::{Integers, SimdI32};

/// Loads from an address per lane.
pub trait Gather: Integers {
    /// Loads 32-bit words, of any alignment, at byte `SCALE` · offset of `from`.
    ///
    /// # Safety
    /// All four bytes of each word must lie in `from`. Checked in debug builds.
    unsafe fn gather_bytes<const SCALE: i32>(from: &[u8], offset: Self::I32) -> Self::I32;
    /// Loads elements.
    ///
    /// # Safety
    /// `index` must be indices of `from`. Checked in debug builds.
    unsafe fn gather(from: &[f32], index: Self::I32) -> Self;
    /// Loads elements and their successors.
    ///
    /// # Safety
    /// `index` and `index` + 1 must be indices of `from`. Checked in debug builds.
    unsafe fn gather_pairs(from: &[f32], index: Self::I32) -> [Self; 2];
    /// [`Self::gather_bytes`] of four slices.
    ///
    /// # Safety
    /// That of [`Self::gather_bytes`] for each slice.
    #[inline(always)]
    unsafe fn gather_bytes_of_4<const SCALE: i32>(from: [&[u8]; 4], offset: Self::I32) -> [Self::I32; 4] {
        let [a, b, c, d] = from;
        // SAFETY: the caller's.
        unsafe {
            [
                Self::gather_bytes::<SCALE>(a, offset),
                Self::gather_bytes::<SCALE>(b, offset),
                Self::gather_bytes::<SCALE>(c, offset),
                Self::gather_bytes::<SCALE>(d, offset),
            ]
        }
    }
    /// [`Self::gather_pairs`] of four slices.
    ///
    /// # Safety
    /// That of [`Self::gather_pairs`] for each slice.
    #[inline(always)]
    unsafe fn gather_pairs_of_4(from: [&[f32]; 4], index: Self::I32) -> [[Self; 2]; 4] {
        let [a, b, c, d] = from;
        // SAFETY: the caller's.
        unsafe {
            [
                Self::gather_pairs(a, index),
                Self::gather_pairs(b, index),
                Self::gather_pairs(c, index),
                Self::gather_pairs(d, index),
            ]
        }
    }
    /// Loads words and their successors. AVX-512 does it by the faster [`crate::GatherMethod`].
    ///
    /// # Safety
    /// `index` and `index` + 1 must be indices of `from`. Checked in debug builds.
    unsafe fn load_word_pairs(from: &[u32], index: Self::I32) -> [Self::I32; 2];

    /// Whether all lanes of `index`, times `scale`, are indices below `end`.
    fn are_below(index: Self::I32, scale: i32, end: usize) -> bool {
        let mut lanes = [0; MOST_LANES];
        index.store(&mut lanes);
        lanes[..Self::N].iter().all(|&at| at >= 0 && (at as usize) * (scale as usize) < end)
    }
}
