use super::blend::extinction;
use super::segment::SHADOW_STEP;
use fovol_core::TransferFunction;

/// A transfer function as tables over the display value, opacity already corrected for the step.
///
/// There are 255·m + 1 entries, so that every 8-bit value falls exactly on one, and after them one for NaN.
#[derive(Debug, Clone)]
pub struct TransferTable {
    /// Opacity and colour of a primary sample, per entry.
    ///
    /// The first word holds the f32 bits of α for one step, 1 − (1 − a)^step. The second packs the colour: red 11 bits,
    /// green 11 bits, blue 10 bits, red lowest. One read fetches both words.
    pub appearance: Vec<[u32; 2]>,
    /// α for one shadow step, which is four primary steps long.
    pub shadow_alpha: Vec<f32>,
    /// The range of entries with any opacity: the first such index, and one past the last.
    visible: [usize; 2],
}

/// The largest value of the red and green fields.
pub const MAX_RED_GREEN: f32 = 2047.0;
/// The largest value of the blue field.
pub const MAX_BLUE: f32 = 1023.0;

/// Entries per 8-bit value where the function has no steep slope: the table stays in the L1 cache.
const GENTLE: usize = 16;
/// Entries per 8-bit value where the function is steep.
const STEEP: usize = 64;

impl TransferTable {
    /// The tables of `transfer` for primary steps of `step` voxels.
    pub fn new(transfer: &TransferFunction, step: f64) -> Self {
        let fine = if transfer.steepest_slope() > 8.0 { STEEP } else { GENTLE };
        let last = 255 * fine;
        let values = (0..=last).map(|i| i as f64 / last as f64).chain([f64::NAN]);
        let rgba: Vec<[f64; 4]> = values.map(|value| transfer.evaluate(value)).collect();
        let colour = |c: &[f64; 4]| pack([c[0], c[1], c[2]]);
        let shadow_step = step * f64::from(SHADOW_STEP);
        let first = rgba.iter().position(|c| c[3] > 0.0).unwrap_or(rgba.len());
        let end = rgba.iter().rposition(|c| c[3] > 0.0).map_or(first, |last| last + 1);
        Self {
            visible: [first, end],
            appearance: rgba.iter().map(|c| [corrected_opacity(c[3], step).to_bits(), colour(c)]).collect(),
            shadow_alpha: rgba.iter().map(|c| corrected_opacity(c[3], shadow_step)).collect(),
        }
    }

    /// Bounds of the real numbers, exclusive, whose whole parts are indices of anything visible.
    pub fn visible(&self) -> [f32; 2] {
        let [first, end] = self.visible.map(|index| index as f32);
        [first.next_down(), end]
    }

    /// Transmittance of a way of `length` voxels, 1 − α, for every entry; that of NaN is the last.
    pub fn transmittance(&self, transfer: &TransferFunction, length: f64) -> Vec<f32> {
        self.opacities(transfer).map(|opacity| (1.0 - opacity).powf(length) as f32).collect()
    }

    /// Optical depth of a way of `length` voxels for every entry; that of NaN is the last.
    pub fn depths(&self, transfer: &TransferFunction, length: f64) -> Vec<f32> {
        self.opacities(transfer).map(|opacity| (length * extinction(opacity)) as f32).collect()
    }

    /// Opacity per reference length of every entry; that of NaN is the last.
    pub fn opacities<'t>(&self, transfer: &'t TransferFunction) -> impl Iterator<Item = f64> + 't {
        let last = self.last();
        let values = (0..=last).map(move |i| i as f64 / last as f64).chain([f64::NAN]);
        values.map(|value| transfer.evaluate(value)[3])
    }

    /// The entry of the largest value; the one for NaN is the next.
    pub fn last(&self) -> usize {
        self.appearance.len() - 2
    }

    /// The factor from a display value to an index.
    pub fn scale(&self) -> f32 {
        self.last() as f32
    }
}

/// Opacity over `steps` reference lengths: α = 1 − (1 − a)^steps.
pub fn corrected_opacity(opacity: f64, steps: f64) -> f32 {
    (1.0 - (1.0 - opacity).powf(steps)) as f32
}

pub(crate) fn pack(rgb: [f64; 3]) -> u32 {
    let field = |c: f64, most: f32| (c * f64::from(most)).round() as u32;
    field(rgb[0], MAX_RED_GREEN) | field(rgb[1], MAX_RED_GREEN) << 11 | field(rgb[2], MAX_BLUE) << 22
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn opacity_does_not_depend_on_the_step() {
        for a in [0.01, 0.3, 0.9] {
            let half = f64::from(corrected_opacity(a, 0.5));
            assert!((1.0 - (1.0 - half) * (1.0 - half) - a).abs() < 1e-6);
        }
        assert_eq!(corrected_opacity(0.0, 0.5), 0.0);
        assert_eq!(corrected_opacity(1.0, 0.5), 1.0);
    }

    #[test]
    fn entries_are_the_function_at_their_values() {
        let tf = TransferFunction::grey_ramp(1.0);
        let table = TransferTable::new(&tf, 1.0);
        let middle = table.last() / 2;
        assert!((f32::from_bits(table.appearance[middle][0]) - 0.5).abs() < 1e-6);
        assert_eq!(table.appearance[table.last()], [1.0f32.to_bits(), u32::MAX]);
        assert_eq!(table.appearance[table.last() + 1], [0; 2]);
        let red = tf.with_nan([1.0, 0.0, 0.0, 0.25]).unwrap();
        let table = TransferTable::new(&red, 2.0);
        assert_eq!(table.appearance[table.last() + 1], [0.4375f32.to_bits(), 0x7FF]);
        assert_eq!(table.visible()[1], table.scale() + 2.0);
    }
}
