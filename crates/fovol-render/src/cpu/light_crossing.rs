//! A row of columns of light on its way through a slice.

use super::fine::passing;
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
    /// Transmittance from slice to slice, and of the first stretch of a shadow ray; with gradients, optical depth.
    pub tables: [&'a [f32]; 2],
    /// Gradients of the voxels, where the extinction depends on them.
    pub gradients: Option<CrossedGradients<'a>>,
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

/// Gradients of the voxels around a row of columns.
pub struct CrossedGradients<'a> {
    /// Places in the table of gradients, of the same voxels as the lines of entries.
    pub lines: [&'a [f32]; 2],
    /// Factors of the extinction.
    pub factors: &'a [f32],
    /// Places in the table for the last slice.
    pub lengths: &'a mut [f32],
}

impl SimdF32Op for Crossed<'_> {
    type Output = ();

    #[inline(always)]
    fn run<V: SimdF32>(mut self, zero: V) {
        let [down, along] = [zero.splat(self.shares[0]), zero.splat(self.shares[1])];
        let near = zero.splat(self.near);
        let one = zero.splat(1.0);
        let mut at = 0;
        while at < self.count {
            let [here, next] = self.voxels;
            let places = [at + here, at + next];
            let entry = between(self.lines, places, [down, along]);
            let number = zero.iota() + zero.splat(at as f32);
            let (before, through) = (zero.load(&self.entries[at..]), zero.load(&self.through[at..]));
            let passed = zero.load(&self.passed[at..]);
            let from = V::select(before.simd_lt(zero), entry, before);
            let from_here = if self.slices[0] { from } else { entry };
            let to_before = if self.slices[1] { from } else { entry };
            let near_entry = (to_before - from_here).mul_add(near, from_here);
            let mut first = looked_up(near_entry, self.tables[1]);
            let mut passing_here = looked_up(entry, self.tables[0]);
            if let Some(gradients) = &mut self.gradients {
                let length = between(gradients.lines, places, [down, along]);
                let last = zero.load(&gradients.lengths[at..]);
                let from = V::select(before.simd_lt(zero), length, last);
                let from_here = if self.slices[0] { from } else { length };
                let to_before = if self.slices[1] { from } else { length };
                let near_length = (to_before - from_here).mul_add(near, from_here);
                first = passing(first * gradients.factor(near_entry, near_length));
                passing_here = passing(passing_here * gradients.factor(entry, length));
                if self.count - at >= V::N {
                    length.store(&mut gradients.lengths[at..]);
                } else {
                    let ours = zero.iota().simd_lt(zero.splat((self.count - at) as f32));
                    V::select(ours, length, last).store(&mut gradients.lengths[at..]);
                }
            }
            (passed * V::select(is_in(number, &self.sees), first, one)).store(&mut self.light[at..]);
            let now = V::select(is_in(number, &self.casts), passing_here, one);
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

impl CrossedGradients<'_> {
    /// Factors of the extinction at `lengths`; 1 where the entry is NaN.
    #[inline(always)]
    fn factor<V: SimdF32>(&self, entry: V, length: V) -> V {
        let zero = entry.splat(0.0);
        let length = length.max(zero).min(zero.splat((self.factors.len() - 1) as f32));
        // SAFETY: lengths are 0 or more, and at most the last index.
        let factor = unsafe { V::gather(self.factors, (length + zero.splat(0.5)).to_i32()) };
        V::select(entry.simd_ge(zero), factor, zero.splat(1.0))
    }
}

/// Numbers between the voxels at `places` of both lines, the parts `down` and `along` of the way.
#[inline(always)]
fn between<V: SimdF32>(lines: [&[f32]; 2], places: [usize; 2], [down, along]: [V; 2]) -> V {
    let (here, next) = (between_lines(lines, places[0], down), between_lines(lines, places[1], down));
    (next - here).mul_add(along, here)
}

/// Numbers between the lines from `at` on, the part `down` of the way from the first to the second.
#[inline(always)]
fn between_lines<V: SimdF32>(lines: [&[f32]; 2], at: usize, down: V) -> V {
    let above = down.load(&lines[0][at..]);
    let below = down.load(&lines[1][at..]);
    (below - above).mul_add(down, above)
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
