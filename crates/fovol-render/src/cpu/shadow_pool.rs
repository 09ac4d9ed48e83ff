//! Lit samples waiting for their shadow rays.

use super::fine::Points;
use super::lanes::Lanes;

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
    ///
    /// # Safety
    /// The instruction set of `L` must be available, and room reserved.
    #[inline(always)]
    pub unsafe fn push<L: Lanes>(&mut self, m: L::M, position: [L::F; 3], colour: [L::F; 3]) {
        debug_assert!(self.len + L::N <= self.columns[0].len());
        let len = self.len;
        for (column, v) in self.columns.iter_mut().zip(position.into_iter().chain(colour)) {
            // SAFETY: `reserve` left a vector's room after `len`.
            unsafe { L::compress(v, m, column.as_mut_ptr().add(len)) };
        }
        // SAFETY: the caller's.
        self.len += unsafe { L::bits(m) }.count_ones() as usize;
    }

    /// The positions of the samples from `at` on.
    ///
    /// # Safety
    /// The instruction set of `L` must be available, and `at` below the number of samples.
    #[inline(always)]
    pub unsafe fn positions<L: Lanes>(&self, at: usize) -> [L::F; 3] {
        debug_assert!(at < self.len);
        let [x, y, z, ..] = &self.columns;
        // SAFETY: `reserve` left a vector's room after the last sample.
        unsafe { [L::load(x.as_ptr().add(at)), L::load(y.as_ptr().add(at)), L::load(z.as_ptr().add(at))] }
    }

    /// Table entries of a vector of points from `at` on; fine integration stores them in the columns of colours.
    ///
    /// # Safety
    /// The instruction set of `L` must be available, and `at` below the number of samples.
    #[inline(always)]
    pub unsafe fn points<L: Lanes>(&self, at: usize) -> Points<L> {
        debug_assert!(at < self.len);
        let [.., a, b, c, _] = &self.columns;
        // SAFETY: `reserve` left a vector's room after the last sample.
        unsafe {
            let [entry, sum, extinction] = [a, b, c].map(|column| L::load(column.as_ptr().add(at)));
            Points { entry, sum, extinction }
        }
    }

    /// Moves the points from `at` on to `position`, and stores the optical depth `near` between both.
    ///
    /// # Safety
    /// The instruction set of `L` must be available, and `at` below the number of samples.
    #[inline(always)]
    pub unsafe fn set_near<L: Lanes>(&mut self, at: usize, position: [L::F; 3], near: L::F) {
        debug_assert!(at < self.len);
        for (column, v) in self.columns.iter_mut().zip(position.into_iter().chain([near])) {
            // SAFETY: `reserve` left a vector's room after the last sample.
            unsafe { L::store(v, column.as_mut_ptr().add(at)) };
        }
    }

    /// Stores the transmittance at the points from `at` on.
    ///
    /// # Safety
    /// The instruction set of `L` must be available, and `at` below the number of samples.
    #[inline(always)]
    pub unsafe fn set_transmittance<L: Lanes>(&mut self, at: usize, transmittance: L::F) {
        debug_assert!(at < self.len);
        // SAFETY: `reserve` left a vector's room after the last sample.
        unsafe { L::store(transmittance, self.columns[TRANSMITTANCE].as_mut_ptr().add(at)) };
    }

    /// The optical depth near each point `at` and the one after it, and the transmittance beyond.
    ///
    /// # Safety
    /// The instruction set of `L` must be available, and all must be below the number of samples.
    #[inline(always)]
    pub unsafe fn lights<L: Lanes>(&self, at: L::I) -> [[L::F; 2]; 2] {
        // SAFETY: the caller's, and `reserve` left room after the last sample.
        unsafe {
            [NEAR, TRANSMITTANCE].map(|column| {
                let (before, after) = L::gather_words(self.columns[column].as_ptr().cast(), at);
                [L::from_bits(before), L::from_bits(after)]
            })
        }
    }

    /// The transmittances of all samples, for writing.
    pub fn transmittance(&mut self) -> &mut [f32] {
        &mut self.columns[TRANSMITTANCE][..self.len]
    }

    /// Adds T·rgb of the samples `from`…`to` (at most N) to `sums`, lane by lane.
    ///
    /// # Safety
    /// The instruction set of `L` must be available.
    #[inline(always)]
    pub unsafe fn arriving<L: Lanes>(&self, from: usize, to: usize, sums: [L::F; 3]) -> [L::F; 3] {
        // SAFETY: `reserve` left a vector's room after the last sample.
        unsafe {
            let inside = L::lt(L::iota(), L::splat((to - from) as f32));
            let t = L::select(inside, L::load(self.columns[TRANSMITTANCE].as_ptr().add(from)), L::splat(0.0));
            let mut out = sums;
            for c in 0..3 {
                let rgb = L::select(inside, L::load(self.columns[3 + c].as_ptr().add(from)), L::splat(0.0));
                out[c] = L::fma(t, rgb, sums[c]);
            }
            out
        }
    }
}
