//! Vectors of four numbers for pixels of four values.

use glam::Vec4;

/// Loads four elements from index `at` on.
#[inline(always)]
pub fn four(numbers: &[f32], at: usize) -> Vec4 {
    Vec4::from_slice(&numbers[at..at + 4])
}
