//! Reads of the extinction table in lanes.

use crate::scene::{COLOURS, ExtinctionTable};
use bytemuck::cast_slice;
use fovol_simd::{SimdF32, SimdI32};

/// The table's entry nearest to `value`, as a whole number.
#[inline(always)]
pub fn entry<V: SimdF32>(value: V) -> V {
    V::from_i32((value + value.splat(0.5)).to_i32())
}

/// Points of rays, with the table's entries for their values.
#[derive(Clone, Copy)]
pub struct Points<V: SimdF32> {
    /// Whole numbers.
    pub entry: V,
    /// The bits of the integral up to the entry.
    pub sum: V,
    /// τ in units of the table.
    pub extinction: V,
}

impl<V: SimdF32> Points<V> {
    /// Every point takes the one of the lane before; the first is at entry `first` of `table`.
    #[inline(always)]
    pub fn moved_up(&self, table: &ExtinctionTable, first: f32) -> Self {
        let [sum, extinction] = table.entries[first as usize].map(f32::from_bits);
        Self {
            entry: self.entry.moved_up(first),
            sum: self.sum.moved_up(sum),
            extinction: self.extinction.moved_up(extinction),
        }
    }
}

impl ExtinctionTable {
    /// The points at `entry`.
    ///
    /// # Safety
    /// They must be entries of the table.
    #[inline(always)]
    pub unsafe fn points<V: SimdF32>(&self, entry: V) -> Points<V> {
        let index = entry.to_i32();
        // SAFETY: the caller's.
        let [sum, extinction] = unsafe { V::load_word_pairs(cast_slice(&self.entries), index + index) };
        Points { entry, sum: V::from_bits(sum), extinction: V::from_bits(extinction) }
    }

    /// [`Self::mean`] in lanes, as multiples of [`Self::unit`], of values that may have gaps (NaN) or not.
    #[inline(always)]
    pub fn means<V: SimdF32>(&self, front: &Points<V>, behind: &Points<V>, has_gaps: bool) -> V {
        let steps = behind.entry - front.entry;
        let zero = steps.splat(0.0);
        let beside = steps.abs().simd_lt(zero.splat(1.5));
        let difference = V::from_i32(behind.sum.to_bits() - front.sum.to_bits());
        let mean = difference / V::select(beside, zero.splat(1.0), steps);
        let of_both = zero.splat(0.5) * (front.extinction + behind.extinction);
        let mean = V::select(beside, of_both, mean);
        if !has_gaps {
            return mean;
        }
        let nan = f32::from_bits(self.entries[self.nan_entry()][1]);
        V::select(self.is_nan(front, behind), zero.splat(nan), mean)
    }

    /// The packed colours of segments between values that may have gaps (NaN) or not; see [`Self::colour`].
    #[inline(always)]
    pub fn colours_between<V: SimdF32>(
        &self,
        front: &Points<V>,
        behind: &Points<V>,
        has_gaps: bool,
    ) -> V::I32 {
        let zero = front.entry.splat(0.0);
        let half = zero.splat_i32((1 << self.bin_bits) / 2);
        let bin = |entry: V| (entry.to_i32() + half).shr_by(self.bin_bits);
        let (front_bin, behind_bin) = (bin(front.entry), bin(behind.entry));
        let at = front_bin * zero.splat_i32(COLOURS as i32) + behind_bin;
        let at = if has_gaps {
            let nan = V::from_bits(zero.splat_i32((COLOURS * COLOURS) as i32));
            V::select(self.is_nan(front, behind), nan, V::from_bits(at)).to_bits()
        } else {
            at
        };
        // Reads of two words are plain loads: gathers are slow on some processors.
        // SAFETY: bins of entries are columns and rows of the table, which ends with the colour of NaN and a spare.
        let [between, _] = unsafe { V::load_word_pairs(&self.colours, at) };
        let apart = V::from_i32(front_bin - behind_bin);
        let within = apart.abs().simd_lt(zero.splat(0.5));
        if V::bits_of(within) == 0 {
            return between;
        }
        let shows = front.extinction.simd_gt(behind.extinction);
        let entry = V::select(shows, front.entry, behind.entry).to_i32();
        // SAFETY: the table has a colour for every entry, and a spare.
        let [own, _] = unsafe { V::load_word_pairs(&self.entry_colours, entry) };
        let own = V::select(within, V::from_bits(own), V::from_bits(between));
        if !has_gaps {
            return own.to_bits();
        }
        V::select(self.is_nan(front, behind), V::from_bits(between), own).to_bits()
    }

    #[inline(always)]
    fn is_nan<V: SimdF32>(&self, front: &Points<V>, behind: &Points<V>) -> V::Mask {
        front.entry.max(behind.entry).simd_gt(front.entry.splat((self.nan_entry() - 1) as f32))
    }
}
