use super::Arithmetic;

/// Shuffles of vectors that hold N / 4 pixels of four values, or pixels of two or three.
pub trait Pixels: Arithmetic {
    /// Transposes four vectors, pixel by pixel: value i of pixel p of vector v becomes value v of pixel p of vector
    /// i.
    fn pixels_transposed(vectors: [Self; 4]) -> [Self; 4];

    /// Deinterleaves three vectors: number 3·i + n of all becomes lane i of vector n.
    fn deinterleave3(vectors: [Self; 3]) -> [Self; 3];
    /// Repeats each lane three times, in three vectors.
    fn repeat3(self) -> [Self; 3];
    /// Deinterleaves two vectors: the even lanes of both, and the odd ones.
    fn deinterleave2(self, others: Self) -> [Self; 2];

    /// Even pixels of `self` and then of `others`.
    fn evens(self, others: Self) -> Self;
    /// Odd pixels of `self` and then of `others`.
    fn odds(self, others: Self) -> Self;
    /// Interleaves the first halves of the pixels of both vectors.
    fn zip_low(self, others: Self) -> Self;
    /// Interleaves the last halves of the pixels of both vectors.
    fn zip_high(self, others: Self) -> Self;
    /// Spreads the first three quarters of the lanes to pixels of three values and a 0.
    fn with_zeros(self) -> Self;
    /// Packs the first three values of each pixel side by side. Lanes after them are undefined.
    fn without_fourths(self) -> Self;
    /// Copies the fourth value of each pixel to its four lanes.
    fn fourths(self) -> Self;
    /// Replaces the fourth value of each pixel by that of `others`.
    fn with_fourths(self, others: Self) -> Self;
}
