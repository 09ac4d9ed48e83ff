use super::Arithmetic;

/// Operations that move or combine lanes.
pub trait Lanes: Arithmetic {
    /// 0, 1, 2, …
    fn iota(self) -> Self;
    /// Sum of all lanes, in a fixed order.
    fn sum(self) -> f32;
    /// Product of all lanes before each lane (1 in lane 0), and product of all.
    fn products_before(self) -> (Self, f32);
    /// Lane i takes lane i − 1, lane 0 takes `first`.
    fn moved_up(self, first: f32) -> Self;
    /// Lane i takes lane i ^ 1.
    fn neighbours(self) -> Self;
    /// Lane i takes lane i ^ 2.
    fn next_neighbours(self) -> Self;
    /// Packs the lanes where `mask` is set, and stores N lanes, the packed ones first. Lanes after them are undefined.
    ///
    /// # Panics
    /// Where `to` is shorter than the vector.
    fn compress(self, mask: Self::Mask, to: &mut [f32]);
    /// Replaces the lanes where `mask` is set by the first elements of `from`, in order.
    ///
    /// # Panics
    /// Where `from` is shorter than the vector.
    fn expand(self, mask: Self::Mask, from: &[f32]) -> Self;
}
