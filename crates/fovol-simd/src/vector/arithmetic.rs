use std::ops::{Add, BitAnd, Div, Mul, Sub};

/// Number of lanes of the longest vectors.
pub const MOST_LANES: usize = 16;

/// Loads, stores, arithmetic and comparisons, lane by lane.
///
/// A vector exists only where its instructions do: the first one is made by
/// [`Simd::in_vectors`](crate::Simd::in_vectors), and all others derive from it. `splat` and `load` therefore take a
/// vector, whose lanes they ignore.
pub trait Arithmetic:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    /// One truth value per lane.
    type Mask: Copy + BitAnd<Output = Self::Mask>;
    /// Number of lanes.
    const N: usize;

    /// Sets all lanes to `number`.
    fn splat(self, number: f32) -> Self;
    /// Loads the first elements of `from`.
    ///
    /// # Panics
    /// Where `from` is shorter than the vector.
    fn load(self, from: &[f32]) -> Self;
    /// Stores the lanes in the first elements of `to`.
    ///
    /// # Panics
    /// Where `to` is shorter than the vector.
    fn store(self, to: &mut [f32]);

    /// Computes self · factor + more, rounded once where the instruction set has FMA.
    fn mul_add(self, factor: Self, more: Self) -> Self;
    /// Reciprocal of each lane, with an error of at most two units in the last place. Undefined for infinite and
    /// tiny values.
    #[inline(always)]
    fn recip(self) -> Self {
        self.splat(1.0) / self
    }
    /// Larger lanes of both; those of `other` where one is NaN.
    fn max(self, other: Self) -> Self;
    /// Smaller lanes of both; those of `other` where one is NaN.
    fn min(self, other: Self) -> Self;
    /// Absolute values.
    fn abs(self) -> Self;
    /// Square roots.
    fn sqrt(self) -> Self;
    /// Rounds up to whole numbers.
    fn ceil(self) -> Self;

    /// Where lanes are less than those of `other`.
    fn simd_lt(self, other: Self) -> Self::Mask;
    /// Where lanes are greater than those of `other`.
    fn simd_gt(self, other: Self) -> Self::Mask;
    /// Where lanes are greater than those of `other`, or equal.
    fn simd_ge(self, other: Self) -> Self::Mask;
    /// Lanes of `yes` where `mask` is set, else of `no`.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;
    /// Lanes where `mask` is set; others become 0.
    fn zero_unless(self, mask: Self::Mask) -> Self;
    /// One bit per lane of `mask`, lane 0 lowest.
    fn bits_of(mask: Self::Mask) -> u32;
    /// Mask with one lane per bit of `bits`, lane 0 lowest.
    fn mask_of(self, bits: u32) -> Self::Mask;
}
