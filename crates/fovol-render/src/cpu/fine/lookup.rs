//! Reads of the extinction table in lanes.

use super::super::field::Texel;
use super::super::lanes::Lanes;
use crate::scene::{COLOURS, ExtinctionTable};

/// The table's entry nearest to `value`, as a whole number.
///
/// # Safety
/// The instruction set of `L` must be available.
#[inline(always)]
pub unsafe fn entry<L: Lanes>(value: L::F) -> L::F {
    // SAFETY: the caller's.
    unsafe { L::to_f32(L::truncate(L::add(value, L::splat(0.5)))) }
}

/// Points of rays, with the table's entries for their values.
#[derive(Clone, Copy)]
pub struct Points<L: Lanes> {
    /// Whole numbers.
    pub entry: L::F,
    /// The bits of the integral up to the entry.
    pub sum: L::F,
    /// τ in units of the table.
    pub extinction: L::F,
}

impl<L: Lanes> Points<L> {
    /// Every point takes the one of the lane before; the first is at entry `first` of `table`.
    ///
    /// # Safety
    /// The instruction set of `L` must be available, and `first` must be an entry.
    #[inline(always)]
    pub unsafe fn moved_up(&self, table: &ExtinctionTable, first: f32) -> Self {
        let [sum, extinction] = table.entries[first as usize].map(f32::from_bits);
        // SAFETY: the caller's.
        unsafe {
            Self {
                entry: L::moved_up(self.entry, first),
                sum: L::moved_up(self.sum, sum),
                extinction: L::moved_up(self.extinction, extinction),
            }
        }
    }
}

impl ExtinctionTable {
    /// The points at `entry`.
    ///
    /// # Safety
    /// The instruction set of `L` must be available, and `entry` must be entries of the table.
    #[inline(always)]
    pub unsafe fn points<L: Lanes>(&self, entry: L::F) -> Points<L> {
        // SAFETY: the caller's.
        unsafe {
            let index = L::truncate(entry);
            let (sum, extinction) = L::gather_words(self.entries.as_ptr().cast(), L::add_i(index, index));
            Points { entry, sum: L::from_bits(sum), extinction: L::from_bits(extinction) }
        }
    }

    /// [`Self::mean`] in lanes, as multiples of [`Self::unit`], of values of a field of `T`.
    ///
    /// # Safety
    /// The instruction set of `L` must be available.
    #[inline(always)]
    pub unsafe fn means<L: Lanes, T: Texel>(&self, front: &Points<L>, behind: &Points<L>) -> L::F {
        // SAFETY: the caller's.
        unsafe {
            let steps = L::sub(behind.entry, front.entry);
            let beside = L::lt(L::abs(steps), L::splat(1.5));
            let difference = L::to_f32(L::sub_i(L::to_bits(behind.sum), L::to_bits(front.sum)));
            let mean = L::div(difference, L::select(beside, L::splat(1.0), steps));
            let of_both = L::mul(L::splat(0.5), L::add(front.extinction, behind.extinction));
            let mean = L::select(beside, of_both, mean);
            if !T::GAPS {
                return mean;
            }
            let nan = f32::from_bits(self.entries[self.nan_entry()][1]);
            L::select(self.is_nan::<L>(front, behind), L::splat(nan), mean)
        }
    }

    /// The packed colours of segments of a field of `T`; see [`Self::colour`].
    ///
    /// # Safety
    /// The instruction set of `L` must be available.
    #[inline(always)]
    pub unsafe fn colours_between<L: Lanes, T: Texel>(&self, front: &Points<L>, behind: &Points<L>) -> L::I {
        // SAFETY: the caller's.
        unsafe {
            let half = L::splat_i((1 << self.bin_bits) / 2);
            let bin = |entry: L::F| L::shr_by(L::add_i(L::truncate(entry), half), self.bin_bits);
            let (front_bin, behind_bin) = (bin(front.entry), bin(behind.entry));
            let at = L::add_i(L::mul_i(front_bin, L::splat_i(COLOURS as i32)), behind_bin);
            let at = if T::GAPS {
                let nan = L::from_bits(L::splat_i((COLOURS * COLOURS) as i32));
                L::to_bits(L::select(self.is_nan::<L>(front, behind), nan, L::from_bits(at)))
            } else {
                at
            };
            // Reads of two words are plain loads: gathers are slow on some processors.
            let between = L::gather_words(self.colours.as_ptr(), at).0;
            let apart = L::to_f32(L::sub_i(front_bin, behind_bin));
            let within = L::lt(L::abs(apart), L::splat(0.5));
            if L::bits(within) == 0 {
                return between;
            }
            let shows = L::gt(front.extinction, behind.extinction);
            let entry = L::truncate(L::select(shows, front.entry, behind.entry));
            let own = L::gather_words(self.entry_colours.as_ptr(), entry).0;
            let own = L::select(within, L::from_bits(own), L::from_bits(between));
            if !T::GAPS {
                return L::to_bits(own);
            }
            L::to_bits(L::select(self.is_nan::<L>(front, behind), L::from_bits(between), own))
        }
    }

    #[inline(always)]
    unsafe fn is_nan<L: Lanes>(&self, front: &Points<L>, behind: &Points<L>) -> L::M {
        // SAFETY: the caller's.
        unsafe { L::gt(L::max(front.entry, behind.entry), L::splat((self.nan_entry() - 1) as f32)) }
    }
}
