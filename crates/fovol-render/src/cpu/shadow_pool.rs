//! Lit samples waiting for their shadow rays.

use super::fine::Points;
use bytemuck::cast_slice;
use fovol_simd::SimdF32;

/// Samples of one or more rays: positions, the colours that full light would add, and (once traced) transmittances.
#[derive(Default)]
pub struct ShadowPool {
    /// x, y, z in voxel-centre coordinates; r, g, b of the light's part; transmittance.
    columns: [Vec<f32>; 7],
    len: usize,
}

const TRANSMITTANCE: usize = 6;
/// The column of the optical depth near a point, in fine integration.
///
/// Until that depth is known, the three columns of colours hold the point's table entries.
const NEAR: usize = 3;

impl ShadowPool {
    /// How many samples wait.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether none waits.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Forgets all samples, keeps the memory.
    pub fn clear(&mut self) {
        self.len = 0;
    }

    /// Makes room for `more` samples and one vector beyond them.
    pub fn reserve(&mut self, more: usize) {
        let needed = self.len + more + 64;
        if self.columns[0].len() < needed {
            let size = needed.next_power_of_two();
            self.columns.iter_mut().for_each(|c| c.resize(size, 0.0));
        }
    }

    /// Appends the lanes of `position` and `colour` where `m` holds.
    #[inline(always)]
    pub fn push<V: SimdF32>(&mut self, m: V::Mask, position: [V; 3], colour: [V; 3]) {
        debug_assert!(self.len + V::N <= self.columns[0].len());
        let len = self.len;
        for (column, v) in self.columns.iter_mut().zip(position.into_iter().chain(colour)) {
            v.compress(m, &mut column[len..]);
        }
        self.len += V::bits_of(m).count_ones() as usize;
    }

    /// Red, green and blue of all samples, and room beyond them.
    #[inline(always)]
    pub fn colours(&self) -> [&[f32]; 3] {
        let [_, _, _, r, g, b, _] = &self.columns;
        [r, g, b]
    }

    /// Appends sample `at` of `other`, with `weight` times its colour.
    pub fn push_weighted(&mut self, other: &Self, at: usize, weight: f32) {
        self.push_copy(other, at);
        self.columns[3..6].iter_mut().for_each(|column| column[self.len - 1] *= weight);
    }

    /// Appends sample `at` of `other`.
    pub fn push_copy(&mut self, other: &Self, at: usize) {
        for (column, other) in self.columns.iter_mut().zip(&other.columns) {
            column[self.len] = other[at];
        }
        self.len += 1;
    }

    /// The positions of the samples from `at` on.
    #[inline(always)]
    pub fn positions<V: SimdF32>(&self, zero: V, at: usize) -> [V; 3] {
        debug_assert!(at < self.len);
        let [x, y, z, ..] = &self.columns;
        [zero.load(&x[at..]), zero.load(&y[at..]), zero.load(&z[at..])]
    }

    /// Table entries of a vector of points from `at` on; fine integration stores them in the columns of colours.
    #[inline(always)]
    pub fn points<V: SimdF32>(&self, zero: V, at: usize) -> Points<V> {
        debug_assert!(at < self.len);
        let [.., a, b, c, _] = &self.columns;
        Points { entry: zero.load(&a[at..]), sum: zero.load(&b[at..]), extinction: zero.load(&c[at..]) }
    }

    /// Moves the points from `at` on to `position`, and stores the optical depth `near` between both.
    #[inline(always)]
    pub fn set_near<V: SimdF32>(&mut self, at: usize, position: [V; 3], near: V) {
        debug_assert!(at < self.len);
        for (column, v) in self.columns.iter_mut().zip(position.into_iter().chain([near])) {
            v.store(&mut column[at..]);
        }
    }

    /// Stores the transmittance at the points from `at` on.
    #[inline(always)]
    pub fn set_transmittance<V: SimdF32>(&mut self, at: usize, transmittance: V) {
        debug_assert!(at < self.len);
        transmittance.store(&mut self.columns[TRANSMITTANCE][at..]);
    }

    /// The optical depth near each point `at` and the one after it, and the transmittance beyond.
    ///
    /// # Safety
    /// All must be below the number of samples.
    #[inline(always)]
    pub unsafe fn lights<V: SimdF32>(&self, at: V::I32) -> [[V; 2]; 2] {
        let [near, far] = [&self.columns[NEAR], &self.columns[TRANSMITTANCE]];
        // SAFETY: the caller's.
        let ([a, b], [c, d]) =
            unsafe { (V::load_word_pairs(cast_slice(near), at), V::load_word_pairs(cast_slice(far), at)) };
        [[V::from_bits(a), V::from_bits(b)], [V::from_bits(c), V::from_bits(d)]]
    }

    /// The transmittances of all samples, for writing.
    pub fn transmittance(&mut self) -> &mut [f32] {
        &mut self.columns[TRANSMITTANCE][..self.len]
    }

    /// Adds (T − 1)·rgb of the samples `from`…`to` (at most N) to `sums`, lane by lane: the light that shadows take away.
    #[inline(always)]
    pub fn shadow<V: SimdF32>(&self, from: usize, to: usize, sums: [V; 3]) -> [V; 3] {
        let zero = sums[0].splat(0.0);
        let inside = zero.iota().simd_lt(zero.splat((to - from) as f32));
        let dark = zero.load(&self.columns[TRANSMITTANCE][from..]) - zero.splat(1.0);
        let dark = V::select(inside, dark, zero);
        let mut out = sums;
        for c in 0..3 {
            let rgb = V::select(inside, zero.load(&self.columns[3 + c][from..]), zero);
            out[c] = dark.mul_add(rgb, sums[c]);
        }
        out
    }
}
