use crate::FrameSize;

/// Sampling mask of a frame, one bit per pixel.
///
/// Rows are padded to whole 64-bit words so that rows can be written in parallel. Bit `x % 64` of word `x / 64` is
/// pixel x. Padding bits are 0.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SampleMask {
    size: FrameSize,
    words_per_row: usize,
    words: Vec<u64>,
}

impl SampleMask {
    /// Mask that samples nothing.
    pub fn none(size: FrameSize) -> Self {
        let words_per_row = (size.width as usize).div_ceil(64);
        Self { size, words_per_row, words: vec![0; words_per_row * size.height as usize] }
    }

    /// Mask that samples every pixel.
    pub fn full(size: FrameSize) -> Self {
        Self::from_fn(size, |_, _| true)
    }

    /// Mask of the pixels (x, y) for which `sampled` returns true.
    pub fn from_fn(size: FrameSize, mut sampled: impl FnMut(u32, u32) -> bool) -> Self {
        let mut mask = Self::none(size);
        for y in 0..size.height {
            for x in 0..size.width {
                if sampled(x, y) {
                    mask.set(x, y);
                }
            }
        }
        mask
    }

    /// Size of the frame.
    pub fn size(&self) -> FrameSize {
        self.size
    }

    /// Words per row.
    pub fn words_per_row(&self) -> usize {
        self.words_per_row
    }

    /// All words, row by row.
    pub fn words(&self) -> &[u64] {
        &self.words
    }

    /// Mutable words, row by row. Padding bits must stay 0.
    pub fn words_mut(&mut self) -> &mut [u64] {
        &mut self.words
    }

    /// Whether pixel (`x`, `y`) is sampled.
    ///
    /// # Panics
    /// If the pixel lies outside the frame.
    pub fn contains(&self, x: u32, y: u32) -> bool {
        assert!(x < self.size.width, "column {x} outside a frame of {}", self.size);
        self.words[y as usize * self.words_per_row + x as usize / 64] >> (x % 64) & 1 == 1
    }

    /// Marks pixel (`x`, `y`) as sampled.
    ///
    /// # Panics
    /// If the pixel lies outside the frame.
    pub fn set(&mut self, x: u32, y: u32) {
        assert!(x < self.size.width, "column {x} outside a frame of {}", self.size);
        self.words[y as usize * self.words_per_row + x as usize / 64] |= 1 << (x % 64);
    }

    /// Number of sampled pixels.
    pub fn count(&self) -> usize {
        self.words.iter().map(|w| w.count_ones() as usize).sum()
    }

    /// Fraction of pixels that are sampled.
    pub fn density(&self) -> f64 {
        self.count() as f64 / self.size.pixels() as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_padded_with_zeros() {
        let mask = SampleMask::full(FrameSize::new(70, 3).unwrap());
        assert_eq!(mask.words_per_row(), 2);
        assert_eq!(mask.count(), 210);
        assert_eq!(mask.density(), 1.0);
        assert_eq!(mask.words()[1], 0b11_1111);
    }
}
