//! The transfer function, integrated over values.

use super::transfer_table::{TransferTable, pack};
use fovol_core::TransferFunction;
use rayon::prelude::*;

/// Bins of values that colours are tabulated for: one around every 8-bit value.
pub const COLOURS: usize = 256;
/// Above this opacity of a voxel extinction rises no more: 1 would be infinite.
const MOST_OPACITY: f64 = 1.0 - 1e-6;
/// The largest sum that the integral takes, in its own unit.
const MOST_SUM: f64 = (1u32 << 30) as f64;
/// Parts that a segment is cut into to find its colour.
const PARTS: usize = 16;

/// Tables of fine integration: extinction and colour of a ray segment between two display values, front to back.
///
/// A voxel of opacity a has the extinction −ln(1 − a). A step of Δ voxels has τ, Δ times as much.
#[derive(Debug, Clone)]
pub struct ExtinctionTable {
    /// For every entry of the [`TransferTable`], the integral of τ from the first entry to this one, and τ itself.
    ///
    /// Both are multiples of [`Self::unit`]. Integrals are whole numbers, so differences are exact; τ is the bits of an
    /// f32. One read fetches both words. NaN is the last entry.
    pub entries: Vec<[u32; 2]>,
    /// The τ of one unit of the table.
    pub unit: f32,
    /// Packed colours between bin f (0…255) in front and b behind, at f·256 + b; see [`pack`].
    /// The colour of NaN comes after them; one word more, so that two can be read anywhere.
    pub colours: Vec<u32>,
    /// Packed colours of single entries, for segments within one bin; NaN last, and one word more.
    pub entry_colours: Vec<u32>,
    /// log2 of the entries in a bin; see [`Self::bin`].
    pub bin_bits: u32,
}

impl ExtinctionTable {
    /// The tables of `transfer` for steps of `step` voxels, with the entries of `table`.
    pub fn new(transfer: &TransferFunction, table: &TransferTable, step: f64) -> Self {
        let last = table.last();
        let extinction = |v: f64| -step * (-transfer.evaluate(v)[3].min(MOST_OPACITY)).ln_1p();
        let each: Vec<f64> = (0..=last).map(|i| extinction(i as f64 / last as f64)).collect();
        let total: f64 = each.iter().sum();
        let unit = if total > 0.0 { total / MOST_SUM } else { 1.0 };
        let entry = |sum: f64, tau: f64| [(sum / unit).round() as u32, ((tau / unit) as f32).to_bits()];
        let mut sum = 0.0;
        let mut before = each[0];
        let mut entries = Vec::with_capacity(each.len() + 1);
        for &tau in &each {
            sum += if entries.is_empty() { 0.0 } else { 0.5 * (before + tau) };
            before = tau;
            entries.push(entry(sum, tau));
        }
        entries.push(entry(sum, extinction(f64::NAN)));
        let bin_bits = (last / (COLOURS - 1)).ilog2();
        let mut entry_colours: Vec<u32> = table.appearance.iter().map(|[_, colour]| *colour).collect();
        entry_colours.push(0);
        let mut out = Self { entries, unit: unit as f32, colours: Vec::new(), entry_colours, bin_bits };
        let emitted = Emitted::new(transfer, &each);
        let pairs = (0..COLOURS * COLOURS).into_par_iter();
        out.colours = pairs.map(|i| out.colour_between(&emitted, i / COLOURS, i % COLOURS)).collect();
        let [r, g, b, _] = transfer.nan();
        out.colours.extend([pack([r, g, b]); 2]);
        out
    }

    /// The entry of NaN.
    pub fn nan_entry(&self) -> usize {
        self.entries.len() - 1
    }

    /// τ between the entries `front` and `behind`: the mean from one to the other.
    pub fn mean(&self, front: usize, behind: usize) -> f32 {
        let nan = self.nan_entry();
        let tau = |entry: usize| f32::from_bits(self.entries[entry][1]);
        if front.max(behind) >= nan {
            return tau(nan) * self.unit;
        }
        if front.abs_diff(behind) <= 1 {
            return 0.5 * (tau(front) + tau(behind)) * self.unit;
        }
        let difference = (self.entries[behind][0] as i32 - self.entries[front][0] as i32) as f32;
        difference / (behind as f32 - front as f32) * self.unit
    }

    /// The bin of `entry`: that of the nearest 8-bit value.
    pub fn bin(&self, entry: usize) -> usize {
        (entry + (1 << self.bin_bits) / 2) >> self.bin_bits
    }

    /// The packed colour of a segment between the table's entries `front` and `behind`.
    ///
    /// Within one bin it is the colour of the end with more extinction, as bands of colour may be narrower than a bin.
    pub fn colour(&self, front: usize, behind: usize) -> u32 {
        if front.max(behind) >= self.nan_entry() {
            return self.colours[COLOURS * COLOURS];
        }
        let bins = [front, behind].map(|entry| self.bin(entry));
        if bins[0] == bins[1] {
            let tau = [front, behind].map(|entry| f32::from_bits(self.entries[entry][1]));
            return self.entry_colours[if tau[0] > tau[1] { front } else { behind }];
        }
        self.colours[bins[0] * COLOURS + bins[1]]
    }

    /// The packed colour that a segment of one step between the bins `front` and `behind` sends to the eye.
    ///
    /// It integrates from the outer end of one bin to the outer end of the other, so both bins count in full.
    fn colour_between(&self, emitted: &Emitted, front: usize, behind: usize) -> u32 {
        let most = (self.nan_entry() - 1) as f64;
        let width = f64::from(1u32 << self.bin_bits);
        let outwards = if front <= behind { 0.5 } else { -0.5 };
        let ends = [front as f64 - outwards, behind as f64 + outwards];
        let at = |part: usize| {
            let value = ends[0] + (ends[1] - ends[0]) * part as f64 / PARTS as f64;
            (value * width).clamp(0.0, most).round() as usize
        };
        let (mut passing, mut colour) = (1.0f64, [0.0f64; 3]);
        for part in 0..PARTS {
            let through = (-f64::from(self.mean(at(part), at(part + 1))) / PARTS as f64).exp();
            let weight = passing * (1.0 - through);
            passing *= through;
            let rgb = emitted.mean(at(part), at(part + 1));
            for c in 0..3 {
                colour[c] += weight * rgb[c];
            }
        }
        let opacity = 1.0 - passing;
        if opacity > 1e-9 { pack(colour.map(|c| c / opacity)) } else { pack(emitted.mean(at(0), at(PARTS))) }
    }
}

/// Sums over the entries before each: of light of every colour, which is the colour times its extinction, and of
/// extinction.
///
/// The colour between two values is the mean of all colours between them, weighted by extinction. Where the transfer
/// function jumps, a transparent colour on one side thus does not tint the other.
struct Emitted {
    sums: Vec<[f64; 4]>,
}

/// Extra weight of every colour, as a fraction of the greatest extinction.
///
/// It gives a colour to ranges without extinction.
const HIDDEN: f64 = 1e-9;

impl Emitted {
    /// The sums for the extinctions `tau` of all entries.
    fn new(transfer: &TransferFunction, tau: &[f64]) -> Self {
        let greatest = tau.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
        let mut sum = [0.0; 4];
        let mut sums = vec![sum];
        let last = (tau.len() - 1) as f64;
        for (i, tau) in tau.iter().enumerate() {
            let [r, g, b, _] = transfer.evaluate(i as f64 / last);
            let weight = tau + HIDDEN * greatest;
            sum = [sum[0] + weight * r, sum[1] + weight * g, sum[2] + weight * b, sum[3] + weight];
            sums.push(sum);
        }
        Self { sums }
    }

    /// The mean colour between the entries `a` and `b`.
    fn mean(&self, a: usize, b: usize) -> [f64; 3] {
        let (before, through) = (self.sums[a.min(b)], self.sums[a.max(b) + 1]);
        let weight = through[3] - before[3];
        std::array::from_fn(|c| (through[c] - before[c]) / weight)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovol_core::ControlPoint;

    /// Hidden blue up to one half, from there opaque yellow.
    fn step() -> ExtinctionTable {
        let point = ControlPoint::new;
        let (hidden, shown) = ([0.0, 0.0, 1.0], [1.0, 0.8, 0.0]);
        let points = vec![
            point(0.0, hidden, 0.0),
            point(0.5, hidden, 0.0),
            point(0.5, shown, 0.95),
            point(1.0, shown, 0.95),
        ];
        let transfer = TransferFunction::new(points).unwrap();
        ExtinctionTable::new(&transfer, &TransferTable::new(&transfer, 0.5), 0.5)
    }

    #[test]
    fn means_are_the_shares_of_what_shows() {
        let table = step();
        let last = table.nan_entry() - 1;
        let whole = -0.5 * 0.05f32.ln();
        assert!((table.mean(last, last) - whole).abs() < 1e-5);
        assert!((table.mean(0, last) - 0.5 * whole).abs() < 2e-3 * whole);
        assert!((table.mean(last, last / 4) - 2.0 / 3.0 * whole).abs() < 1e-3 * whole);
        assert_eq!(table.mean(3, 17), 0.0);
        assert_eq!(table.mean(5, 5), 0.0);
    }

    #[test]
    fn a_hidden_colour_tints_nothing() {
        let table = step();
        let last = table.nan_entry() - 1;
        let shown = pack([1.0, 0.8, 0.0]);
        for (front, behind) in
            [(last, last), (0, last), (last, 0), (last / 2 - 9, last / 2 + 9), (last / 2 + 1, last / 2 + 1)]
        {
            assert_eq!(table.colour(front, behind), shown, "{front} {behind}");
        }
        // Transparent ranges have a colour too.
        assert_eq!(table.colour(3, 17), pack([0.0, 0.0, 1.0]));
    }

    #[test]
    fn bands_narrower_than_a_bin_keep_their_colours() {
        let point = ControlPoint::new;
        let (red, green) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
        let points = vec![
            point(0.5, red, 0.9),
            point(0.501, red, 0.9),
            point(0.501, green, 0.9),
            point(0.503, green, 0.9),
        ];
        let transfer = TransferFunction::new(points).unwrap();
        let table = ExtinctionTable::new(&transfer, &TransferTable::new(&transfer, 0.5), 0.5);
        let entry = |v: f64| (v * (table.nan_entry() - 1) as f64).round() as usize;
        assert_eq!(table.colour(entry(0.5005), entry(0.5005)), pack(red));
        assert_eq!(table.colour(entry(0.5015), entry(0.5015)), pack(green));
    }
}
