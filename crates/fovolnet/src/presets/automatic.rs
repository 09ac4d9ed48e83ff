//! Transfer functions made from histograms, and colour maps.

use fovol_core::{ControlPoint, TransferFunction, Volume};

/// Pieces into which a colour map is cut; its colours are linear within each.
const MAP_PARTS: u32 = 32;

/// Combines the colours of `gradient` with the opacity of `transfer`.
pub(super) fn coloured(transfer: &TransferFunction, gradient: &colorous::Gradient) -> TransferFunction {
    let at = |value, opacity| ControlPoint::new(value, colour(gradient, value), opacity);
    let corners = transfer.points();
    let mut points: Vec<_> = corners.iter().map(|corner| at(corner.value, corner.opacity)).collect();
    let between = (0..=MAP_PARTS).map(|i| f64::from(i) / f64::from(MAP_PARTS));
    // An existing control point may be one side of a step, so leave it alone.
    let between = between.filter(|&value| corners.iter().all(|corner| corner.value != value));
    points.extend(between.map(|value| at(value, transfer.evaluate(value)[3])));
    points.sort_by(|a, b| a.value.total_cmp(&b.value));
    let coloured = TransferFunction::new(points).expect("values rise");
    coloured.with_range(transfer.range()).expect("the range was one")
}

/// Colour of `gradient` at `v`.
pub(super) fn colour(gradient: &colorous::Gradient, v: f64) -> [f64; 3] {
    let c = gradient.eval_continuous(v);
    [c.r, c.g, c.b].map(|c| f64::from(c) / 255.0)
}

/// Bins of the histogram.
const BINS: usize = 256;

/// Makes a transfer function from the histogram of `volume`. Values below Otsu's threshold are background and
/// transparent. Opacity grows with the value above it. Warm colours change fastest where most values lie.
pub fn automatic(volume: &Volume) -> TransferFunction {
    let [lo, hi] = volume.range();
    let counts = volume.histogram(BINS, [lo, hi]);
    let threshold = threshold(&counts);
    let foreground: u64 = counts[threshold..].iter().sum();
    let total: u64 = counts.iter().sum();
    // If most of the volume is visible, it must be thin to be seen through.
    let share = if total > 0 { foreground as f64 / total as f64 } else { 1.0 };
    let densest = (0.9 - 1.2 * share).clamp(0.15, 0.9);
    let start = threshold as f64 / BINS as f64;
    let mut points = vec![ControlPoint::new(0.0, colour(&colorous::INFERNO, 0.15), 0.0)];
    if start > 0.0 {
        points.push(ControlPoint::new(start, colour(&colorous::INFERNO, 0.3), 0.0));
    }
    for i in 1..=8 {
        let part = f64::from(i) / 8.0;
        // Value below which the fraction `part` of the foreground lies.
        let equalised = quantile(&counts, threshold, part) as f64 / BINS as f64;
        let v = (0.5 * equalised + 0.5 * (start + part * (1.0 - start))).min(1.0);
        let last = points[points.len() - 1].value;
        points.push(ControlPoint::new(
            v.max(last),
            colour(&colorous::INFERNO, 0.3 + 0.68 * part),
            densest * part * part,
        ));
    }
    points.push(ControlPoint::new(1.0, colour(&colorous::INFERNO, 0.98), densest));
    TransferFunction::new(points).expect("values rise")
}

/// First bin below which the fraction `part` of the values at or above `from` lies.
fn quantile(counts: &[u64], from: usize, part: f64) -> usize {
    let total: u64 = counts[from..].iter().sum();
    let mut below = 0;
    for (bin, &count) in counts.iter().enumerate().skip(from) {
        below += count;
        if below as f64 >= part * total as f64 {
            return bin + 1;
        }
    }
    counts.len()
}

/// Display value that parts the values of `volume` into two groups, by Otsu's threshold.
pub fn otsu(volume: &Volume) -> f64 {
    let counts = volume.histogram(BINS, volume.range());
    // Between bins, so that voxels of one value lie on one side.
    (threshold(&counts) as f64 - 0.5).max(0.5) / BINS as f64
}

/// First bin of the brighter class by Otsu's threshold (1979), which maximises the variance between two classes.
fn threshold(counts: &[u64]) -> usize {
    let total: f64 = counts.iter().map(|&c| c as f64).sum();
    let sum: f64 = counts.iter().enumerate().map(|(i, &c)| i as f64 * c as f64).sum();
    let (mut below, mut sum_below) = (0.0, 0.0);
    let mut best = (0.0, 0);
    for (i, &count) in counts.iter().enumerate() {
        below += count as f64;
        sum_below += i as f64 * count as f64;
        let above = total - below;
        if below > 0.0 && above > 0.0 {
            let apart = sum_below / below - (sum - sum_below) / above;
            let between = below * above * apart * apart;
            if between > best.0 {
                best = (between, i + 1);
            }
        }
    }
    best.1
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovol_core::Grid;

    fn volume(values: Vec<u8>) -> Volume {
        let grid = Grid::new([values.len(), 1, 1], [1.0; 3]).unwrap();
        Volume::from_values(grid, values).unwrap()
    }

    #[test]
    fn background_is_transparent_and_objects_are_not() {
        let mut values = vec![10u8; 900];
        values.extend(vec![180u8; 100]);
        let tf = automatic(&volume(values));
        assert_eq!(tf.evaluate(10.0 / 255.0)[3], 0.0);
        assert!(tf.evaluate(180.0 / 255.0)[3] > 0.1);
    }

    #[test]
    fn a_constant_volume_has_one_too() {
        automatic(&volume(vec![7; 10]));
        automatic(&volume(vec![255; 10]));
    }
}
