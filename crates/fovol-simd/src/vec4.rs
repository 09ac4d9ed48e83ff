//! One pixel of four values as a vector, for the ends of rows. It needs no instruction set.

use crate::bf16::UPPER_HALF;
use crate::vector::{Arithmetic, Pixels, Storage};
use glam::{BVec4A, Mat4, Vec4};

impl Arithmetic for Vec4 {
    type Mask = BVec4A;
    const N: usize = 4;

    #[inline(always)]
    fn splat(self, number: f32) -> Self {
        Self::splat(number)
    }
    #[inline(always)]
    fn load(self, from: &[f32]) -> Self {
        Self::from_slice(from)
    }
    #[inline(always)]
    fn store(self, to: &mut [f32]) {
        self.write_to_slice(to);
    }
    #[inline(always)]
    fn mul_add(self, factor: Self, more: Self) -> Self {
        self * factor + more
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        self.max(other)
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        self.min(other)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        self.abs()
    }
    #[inline(always)]
    fn simd_ge(self, other: Self) -> BVec4A {
        self.cmpge(other)
    }
    #[inline(always)]
    fn simd_lt(self, other: Self) -> BVec4A {
        self.cmplt(other)
    }
    #[inline(always)]
    fn zero_unless(self, mask: BVec4A) -> Self {
        Self::select(mask, self, Self::ZERO)
    }
    #[inline(always)]
    fn recip(self) -> Self {
        Self::ONE / self
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self::from_array(self.to_array().map(f32::sqrt))
    }
    #[inline(always)]
    fn ceil(self) -> Self {
        self.ceil()
    }
    #[inline(always)]
    fn simd_gt(self, other: Self) -> BVec4A {
        self.cmpgt(other)
    }
    #[inline(always)]
    fn select(mask: BVec4A, yes: Self, no: Self) -> Self {
        Self::select(mask, yes, no)
    }
    #[inline(always)]
    fn bits_of(mask: BVec4A) -> u32 {
        mask.bitmask()
    }
    #[inline(always)]
    fn mask_of(self, bits: u32) -> BVec4A {
        BVec4A::from_array(std::array::from_fn(|i| bits >> i & 1 == 1))
    }
}

impl Pixels for Vec4 {
    #[inline(always)]
    fn pixels_transposed(vectors: [Self; 4]) -> [Self; 4] {
        let [a, b, c, d] = vectors;
        let columns = Mat4::from_cols(a, b, c, d).transpose();
        [columns.x_axis, columns.y_axis, columns.z_axis, columns.w_axis]
    }
    #[inline(always)]
    fn deinterleave3([a, b, c]: [Self; 3]) -> [Self; 3] {
        [Self::new(a.x, a.w, b.z, c.y), Self::new(a.y, b.x, b.w, c.z), Self::new(a.z, b.y, c.x, c.w)]
    }
    #[inline(always)]
    fn repeat3(self) -> [Self; 3] {
        let [x, y, z, w] = self.to_array();
        [Self::new(x, x, x, y), Self::new(y, y, z, z), Self::new(z, w, w, w)]
    }
    #[inline(always)]
    fn deinterleave2(self, others: Self) -> [Self; 2] {
        [Self::new(self.x, self.z, others.x, others.z), Self::new(self.y, self.w, others.y, others.w)]
    }
    #[inline(always)]
    fn evens(self, _: Self) -> Self {
        self
    }
    #[inline(always)]
    fn odds(self, others: Self) -> Self {
        others
    }
    #[inline(always)]
    fn zip_low(self, _: Self) -> Self {
        self
    }
    #[inline(always)]
    fn zip_high(self, others: Self) -> Self {
        others
    }
    #[inline(always)]
    fn with_zeros(self) -> Self {
        self.with_w(0.0)
    }
    #[inline(always)]
    fn without_fourths(self) -> Self {
        self
    }
    #[inline(always)]
    fn fourths(self) -> Self {
        Self::splat(self.w)
    }
    #[inline(always)]
    fn with_fourths(self, others: Self) -> Self {
        self.with_w(others.w)
    }
}

impl Storage for Vec4 {
    #[inline(always)]
    fn halves(self) -> [Self; 2] {
        let words = self.to_array().map(f32::to_bits);
        [words.map(|word| word << 16), words.map(|word| word & UPPER_HALF)]
            .map(|half| Self::from_array(half.map(f32::from_bits)))
    }
}
