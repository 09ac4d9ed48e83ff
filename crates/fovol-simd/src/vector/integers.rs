use super::Arithmetic;
use std::ops::{Add, BitAnd, Mul, Sub};

/// Vector of i32. Sums and products wrap around.
pub trait SimdI32:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + BitAnd<Output = Self>
{
    /// Sets all lanes to `number`.
    fn splat(self, number: i32) -> Self;
    /// Stores the lanes in the first elements of `to`.
    ///
    /// # Panics
    /// Where `to` is shorter than the vector.
    fn store(self, to: &mut [i32]);
    /// Logical shift right.
    fn shr<const BITS: u32>(self) -> Self;
    /// Logical shift right by a number known at run time.
    fn shr_by(self, bits: u32) -> Self;
    /// Shift left, lane by lane; zeros for 32 and more.
    fn shl_lanes(self, by: Self) -> Self;
    /// Logical shift right, lane by lane; zeros for 32 and more.
    fn shr_lanes(self, by: Self) -> Self;
    /// For each lane of four bytes: byte 2·`PAIR` times the lower half of the weight, plus byte 2·`PAIR` + 1 times the
    /// upper half. Halves of weights are at most 32767.
    fn weighted_bytes<const PAIR: usize>(self, weights: Self) -> Self;
}

/// Conversions between f32 and i32.
pub trait Integers: Arithmetic {
    /// Vector of i32 with as many lanes.
    type I32: SimdI32;

    /// Sets all lanes of an integer vector to `number`.
    fn splat_i32(self, number: i32) -> Self::I32;
    /// Rounds towards 0. Undefined for NaN and beyond i32.
    fn to_i32(self) -> Self::I32;
    /// Converts integers to f32.
    fn from_i32(integers: Self::I32) -> Self;
    /// Bits of the lanes.
    fn to_bits(self) -> Self::I32;
    /// Lanes with these bits.
    fn from_bits(bits: Self::I32) -> Self;
}
