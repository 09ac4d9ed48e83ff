//! The transfer function, integrated over values.

use super::super::transfer_table::{TransferTable, pack};
use fovol_core::TransferFunction;
use rayon::prelude::*;

/// Values that colours are tabulated at: every 8-bit one.
pub const COLOURS: usize = 256;
/// Above this opacity of a voxel extinction rises no more: 1 would be infinite.
const MOST_OPACITY: f64 = 1.0 - 1e-6;
/// The largest sum that the integral takes, in its own unit.
const MOST_SUM: f64 = (1u32 << 30) as f64;
/// Parts that a segment is cut into to find its colour.
const PARTS: usize = 16;

/// What passes between two values: τ, the extinction of one step, and the colour, from front to back.
///
/// The extinction of a voxel with opacity a is −ln(1 − a), that of a step of Δ voxels Δ times as much.
#[derive(Debug, Clone)]
pub struct ExtinctionTable {
    /// The sum of τ over all entries of the [`TransferTable`] before each, as multiples of [`Self::unit`]: whole
    /// numbers, so that a difference is exact wherever it is taken.
    pub sums: Vec<i32>,
    /// τ that one stands for.
    pub unit: f32,
    /// Packed colours between value f (0…255) in front and b behind, at f·256 + b; see [`pack`].
    /// The colour of NaN is the last.
    pub colours: Vec<u32>,
    /// τ of one step that begins or ends in NaN.
    pub nan: f32,
}

impl ExtinctionTable {
    /// The tables of `transfer` for steps of `step` voxels, with the entries of `table`.
    pub fn new(transfer: &TransferFunction, table: &TransferTable, step: f64) -> Self {
        let last = table.last();
        let extinction = |v: f64| -step * (-transfer.evaluate(v)[3].min(MOST_OPACITY)).ln_1p();
        let each: Vec<f64> = (0..=last).map(|i| extinction(i as f64 / last as f64)).collect();
        let total: f64 = each.iter().sum();
        let unit = if total > 0.0 { total / MOST_SUM } else { 1.0 };
        let mut sum = 0.0;
        let mut sums = vec![0];
        for tau in &each {
            sum += tau;
            sums.push((sum / unit) as i32);
        }
        let nan = extinction(f64::NAN) as f32;
        let mut out = Self { sums, unit: unit as f32, colours: Vec::new(), nan };
        let rgb: Vec<[f64; 3]> = (0..=last)
            .map(|i| {
                let [r, g, b, _] = transfer.evaluate(i as f64 / last as f64);
                [r, g, b]
            })
            .collect();
        let pairs = (0..COLOURS * COLOURS).into_par_iter();
        out.colours = pairs.map(|i| out.colour_between(&rgb, i / COLOURS, i % COLOURS)).collect();
        let [r, g, b, _] = transfer.nan();
        out.colours.push(pack([r, g, b]));
        out
    }

    /// The entry of NaN.
    pub fn nan_entry(&self) -> usize {
        self.sums.len() - 1
    }

    /// τ between the entries `front` and `behind`: the mean of all from one to the other.
    pub fn mean(&self, front: usize, behind: usize) -> f32 {
        let (low, end) = (front.min(behind), front.max(behind) + 1);
        if end > self.nan_entry() {
            return self.nan;
        }
        (self.sums[end] - self.sums[low]) as f32 / (end - low) as f32 * self.unit
    }

    /// The place in [`Self::colours`] for a segment between the table's entries `front` and `behind`. Both are rounded
    /// away from each other, so that nothing that shows between them is left out.
    pub fn colour_at(&self, front: usize, behind: usize) -> usize {
        if front.max(behind) >= self.nan_entry() {
            return COLOURS * COLOURS;
        }
        let scale = (COLOURS - 1) as f32 / (self.sums.len() - 2) as f32;
        let (f, b) = (front as f32 * scale, behind as f32 * scale);
        let (low, high) = (f.min(b) as usize, f.max(b).ceil() as usize);
        if f < b { low * COLOURS + high } else { high * COLOURS + low }
    }

    /// The colour that a segment of one step sends to the eye, between the values `front` and `behind` of 0…255.
    fn colour_between(&self, rgb: &[[f64; 3]], front: usize, behind: usize) -> u32 {
        let fine = (rgb.len() - 1) as f64 / (COLOURS - 1) as f64;
        let at = |part: f64| (front as f64 + (behind as f64 - front as f64) * part / PARTS as f64) * fine;
        let (mut passing, mut colour, mut plain) = (1.0f64, [0.0f64; 3], [0.0f64; 3]);
        for part in 0..PARTS {
            let [from, middle, to] = [0.0, 0.5, 1.0].map(|more| at(part as f64 + more).round() as usize);
            let through = (-f64::from(self.mean(from, to)) / PARTS as f64).exp();
            let weight = passing * (1.0 - through);
            passing *= through;
            for c in 0..3 {
                colour[c] += weight * rgb[middle][c];
                plain[c] += rgb[middle][c];
            }
        }
        let opacity = 1.0 - passing;
        if opacity > 1e-9 { pack(colour.map(|c| c / opacity)) } else { pack(plain.map(|c| c / PARTS as f64)) }
    }
}
