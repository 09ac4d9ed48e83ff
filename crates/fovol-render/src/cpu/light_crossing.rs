//! A row of columns of light on its way through a slice.

use fovol_simd::{SimdF32, SimdF32Op};
use std::ops::Range;

/// Row of columns on its way through a slice.
pub struct Crossed<'a> {
    /// Entries of the lines of voxels before and after the row, from voxel −1 on.
    pub lines: [&'a [f32]; 2],
    /// Places of the voxels before and after a column, from that of the column on.
    pub voxels: [usize; 2],
    /// Of the two entries between which the first sample lies, whether each is that of the slice before.
    pub slices: [bool; 2],
    /// How far behind these lines, and behind their voxels, the columns are.
    pub shares: [f32; 2],
    /// Transmittance from slice to slice, and of the first stretch of a shadow ray.
    pub tables: [&'a [f32]; 2],
    /// Where the sample of the first stretch lies, as a part of the way to the slice before.
    pub near: f32,
    /// Columns that are in the part that casts shadows, and those whose first sample is.
    pub casts: Range<f32>,
    pub sees: Range<f32>,
    pub passed: &'a mut [f32],
    pub through: &'a mut [f32],
    pub entries: &'a mut [f32],
    /// Light that comes to the columns.
    pub light: &'a mut [f32],
    pub count: usize,
}

impl SimdF32Op for Crossed<'_> {
    type Output = ();

    #[inline(always)]
    fn run<V: SimdF32>(self, zero: V) {
        let [down, along] = [zero.splat(self.shares[0]), zero.splat(self.shares[1])];
        let near = zero.splat(self.near);
        let one = zero.splat(1.0);
        let mut at = 0;
        while at < self.count {
            let [here, next] = self.voxels;
            let (here, next) = (self.between_lines(at + here, down), self.between_lines(at + next, down));
            let entry = (next - here).mul_add(along, here);
            let number = zero.iota() + zero.splat(at as f32);
            let (before, through) = (zero.load(&self.entries[at..]), zero.load(&self.through[at..]));
            let passed = zero.load(&self.passed[at..]);
            let from = V::select(before.simd_lt(zero), entry, before);
            let from_here = if self.slices[0] { from } else { entry };
            let to_before = if self.slices[1] { from } else { entry };
            let first = looked_up((to_before - from_here).mul_add(near, from_here), self.tables[1]);
            (passed * V::select(is_in(number, &self.sees), first, one)).store(&mut self.light[at..]);
            let now = V::select(is_in(number, &self.casts), looked_up(entry, self.tables[0]), one);
            if self.count - at >= V::N {
                (passed * through).store(&mut self.passed[at..]);
                now.store(&mut self.through[at..]);
                entry.store(&mut self.entries[at..]);
            } else {
                // What follows the row belongs to columns that cross elsewhere.
                let ours = zero.iota().simd_lt(zero.splat((self.count - at) as f32));
                V::select(ours, passed * through, passed).store(&mut self.passed[at..]);
                V::select(ours, now, through).store(&mut self.through[at..]);
                V::select(ours, entry, before).store(&mut self.entries[at..]);
            }
            at += V::N;
        }
    }
}

impl Crossed<'_> {
    /// Entries between the lines from `at` on, the part `down` of the way from the first to the second.
    #[inline(always)]
    fn between_lines<V: SimdF32>(&self, at: usize, down: V) -> V {
        let above = down.load(&self.lines[0][at..]);
        let below = down.load(&self.lines[1][at..]);
        (below - above).mul_add(down, above)
    }
}

/// Whether each of `numbers` lies in `range`.
#[inline(always)]
fn is_in<V: SimdF32>(numbers: V, range: &Range<f32>) -> V::Mask {
    numbers.simd_ge(numbers.splat(range.start)) & numbers.simd_lt(numbers.splat(range.end))
}

/// Numbers of `table` at the nearest entries. NaN has the last one.
#[inline(always)]
fn looked_up<V: SimdF32>(entry: V, table: &[f32]) -> V {
    let zero = entry.splat(0.0);
    let last = table.len() - 1;
    // Comparisons with NaN are false.
    let inside = entry.min(zero.splat((last - 1) as f32));
    let entry = V::select(entry.simd_ge(zero), inside, zero.splat(last as f32));
    // SAFETY: entries are 0 or more, and at most `last`.
    unsafe { V::gather(table, (entry + zero.splat(0.5)).to_i32()) }
}
