//! Thresholds of the mask, which masks on CPU and GPU compare noise with.

use fovol_core::{Fovea, FrameSize};
#[cfg(feature = "gpu")]
use std::ops::Range;

/// Pixels of one word of a mask.
pub(crate) const WORD: usize = u64::BITS as usize;

/// The threshold τ·levels of every pixel, in its two factors.
///
/// levels is a power of two, so scaling by it rounds nothing: rank + ½ < τ·levels holds exactly where the
/// specification's (rank + ½)/levels < τ does.
pub(crate) struct Thresholds {
    /// P_b·levels.
    pub(crate) base: f64,
    /// (1 − P_b)·levels·(the fovea's factor of the column); 0 beyond the width.
    pub(crate) columns: Vec<[f64; WORD]>,
    /// The largest of every word of columns.
    pub(crate) widest: Vec<f64>,
    /// The bits of the last word of a row that are pixels.
    pub(crate) last_word: u64,
}

impl Thresholds {
    /// The thresholds of `fovea` in frames of `size`, among `levels` ranks.
    pub(crate) fn new(fovea: &Fovea, size: FrameSize, levels: u32) -> Self {
        let levels = f64::from(levels);
        let column = |x: u32| {
            if x < size.width { (1.0 - fovea.base) * fovea.falloff_x(x, size) * levels } else { 0.0 }
        };
        let columns: Vec<[f64; WORD]> = (0..size.width)
            .step_by(WORD)
            .map(|first| std::array::from_fn(|bit| column(first + bit as u32)))
            .collect();
        Self {
            base: fovea.base * levels,
            widest: columns.iter().map(|word| word.iter().copied().fold(0.0, f64::max)).collect(),
            last_word: u64::MAX >> (columns.len() * WORD - size.width as usize),
            columns,
        }
    }

    /// For some columns of a row whose factor of the fovea is `falloff`, how many ranks are sampled there.
    #[cfg(feature = "gpu")]
    pub(crate) fn limits(&self, columns: Range<usize>, falloff: f64) -> impl Iterator<Item = u32> {
        self.columns.as_flattened()[columns].iter().map(move |column| limit(self.base + column * falloff))
    }
}

/// The number of ranks with rank + ½ < `threshold`.
pub(crate) fn limit(threshold: f64) -> u32 {
    // The difference is exact where it is positive. Whoever adds 2⁵² rounds to a whole number, which the low bits then
    // are; rounding up by a call would keep loops from becoming vectors.
    const WHOLE: f64 = (1u64 << 52) as f64;
    let least = (threshold - 0.5).max(0.0);
    let rounded = least + WHOLE;
    rounded.to_bits() as u32 + u32::from(rounded - WHOLE < least)
}
