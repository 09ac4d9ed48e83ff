//! Joint histogram of values and gradient magnitudes.
//!
//! A boundary between two materials appears as an arch: values run from one to the other, and the gradient is
//! steepest half way (Kindlmann and Durkin, Semi-automatic generation of transfer functions, 1998).

use fovolnet::core::Volume;

/// Number of columns, for values.
pub const VALUES: usize = 256;
/// Number of rows, for gradient magnitudes.
pub const MAGNITUDES: usize = 128;
/// Approximate number of voxels counted; larger volumes are subsampled.
pub const ENOUGH: usize = 2_000_000;
/// One in this many voxels may have a gradient beyond the highest row, for example from noise or metal.
const RARE: usize = 10_000;

/// Joint histogram of values and gradient magnitudes.
#[derive(Debug, Clone, PartialEq)]
pub struct Boundaries {
    /// Counts row by row, smallest magnitudes first.
    counts: Vec<u32>,
    /// Largest magnitude of the histogram, in display values per voxel.
    most: f64,
}

impl Boundaries {
    /// Histogram of about `enough` voxels of `volume`.
    pub fn new(volume: &Volume, enough: usize) -> Self {
        let points = points(volume, stride(volume, enough));
        let most = usual_most(&points);
        let mut counts = vec![0; VALUES * MAGNITUDES];
        for [value, magnitude] in points {
            if let Some(row) = row(magnitude, most) {
                counts[row * VALUES + bin(value, VALUES)] += 1;
            }
        }
        Self { counts, most }
    }

    /// Logarithms of the counts, scaled to 0…1.
    pub fn brightness(&self) -> impl Iterator<Item = f32> {
        let most = self.counts.iter().copied().max().unwrap_or(0).max(1) as f32;
        self.counts.iter().map(move |&count| (1.0 + count as f32).ln() / (1.0 + most).ln())
    }
}

/// Row of `magnitude`, or `None` above `most`. Rows are spaced by the square root, since boundaries of soft tissue
/// are faint.
fn row(magnitude: f64, most: f64) -> Option<usize> {
    (magnitude <= most).then(|| bin((magnitude / most.max(f64::MIN_POSITIVE)).sqrt(), MAGNITUDES))
}

/// Index of the bin of 0…1 that contains `share`.
fn bin(share: f64, bins: usize) -> usize {
    ((share * bins as f64) as usize).min(bins - 1)
}

/// Stride along each axis that leaves about `enough` voxels.
fn stride(volume: &Volume, enough: usize) -> usize {
    let part = volume.grid().voxels() as f64 / enough.max(1) as f64;
    (part.cbrt().ceil() as usize).max(1)
}

/// Display values and gradient magnitudes of every `stride`th voxel along each axis. Gradients are central
/// differences over ±1 voxel, in units of the smallest spacing.
fn points(volume: &Volume, stride: usize) -> Vec<[f64; 2]> {
    let (dims, spacing) = (volume.grid().dims(), volume.grid().spacing());
    let voxel = spacing.into_iter().fold(f64::INFINITY, f64::min);
    let at = |voxel: [usize; 3]| volume.normalised(volume.value(voxel));
    let along = |voxel: [usize; 3], axis: usize| {
        let [mut before, mut after] = [voxel; 2];
        before[axis] = voxel[axis].saturating_sub(1);
        after[axis] = (voxel[axis] + 1).min(dims[axis] - 1);
        0.5 * (at(after) - at(before))
    };
    let mut points = Vec::new();
    for z in (0..dims[2]).step_by(stride) {
        for y in (0..dims[1]).step_by(stride) {
            for x in (0..dims[0]).step_by(stride) {
                let here = [x, y, z];
                let square = |axis: usize| (along(here, axis) * voxel / spacing[axis]).powi(2);
                points.push([at(here), (square(0) + square(1) + square(2)).sqrt()]);
            }
        }
    }
    points
}

/// Magnitude that only one in [`RARE`] of `points` exceeds.
fn usual_most(points: &[[f64; 2]]) -> f64 {
    let mut magnitudes: Vec<f64> = points.iter().map(|point| point[1]).collect();
    let rare = magnitudes.len() / RARE;
    match magnitudes.len().checked_sub(1 + rare) {
        Some(i) => *magnitudes.select_nth_unstable_by(i, f64::total_cmp).1,
        None => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovolnet::core::Grid;
    use std::collections::BTreeMap;

    /// Two materials of 40 and 200 with a blurred boundary, in an anisotropic grid.
    fn ball() -> Volume {
        let grid = Grid::new([24, 20, 18], [1.0, 1.0, 2.0]).unwrap();
        let value = |i: usize| {
            let [x, y, z] = [i % 24, i / 24 % 20, i / 480].map(|c| c as f64);
            let away = ((x - 12.0).powi(2) + (y - 10.0).powi(2) + 4.0 * (z - 9.0).powi(2)).sqrt();
            let inside = 1.0 / (1.0 + (1.5 * (away - 7.0)).exp());
            (40.0 + 160.0 * inside).round() as u8
        };
        Volume::from_values(grid, (0..24 * 20 * 18).map(value).collect()).unwrap()
    }

    #[test]
    fn counts_are_those_of_a_plain_computation() {
        let volume = ball();
        let found = Boundaries::new(&volume, usize::MAX);
        let v = |x: i64, y: i64, z: i64| {
            let clamped = [x.clamp(0, 23), y.clamp(0, 19), z.clamp(0, 17)].map(|c| c as usize);
            volume.value(clamped) / 255.0
        };
        let mut expected = BTreeMap::new();
        for z in 0..18 {
            for y in 0..20 {
                for x in 0..24 {
                    let gx = (v(x + 1, y, z) - v(x - 1, y, z)) / 2.0;
                    let gy = (v(x, y + 1, z) - v(x, y - 1, z)) / 2.0;
                    let gz = (v(x, y, z + 1) - v(x, y, z - 1)) / 4.0;
                    let magnitude = (gx * gx + gy * gy + gz * gz).sqrt();
                    let row = ((magnitude / found.most).sqrt() * 128.0).floor().min(127.0) as usize;
                    let column = (v(x, y, z) * 256.0).floor().min(255.0) as usize;
                    *expected.entry((row, column)).or_insert(0) += 1;
                }
            }
        }
        let counted = found.counts.iter().enumerate().filter(|(_, count)| **count > 0);
        let counted: BTreeMap<_, _> = counted.map(|(i, &count)| ((i / VALUES, i % VALUES), count)).collect();
        assert_eq!(counted, expected);
    }

    #[test]
    fn a_boundary_is_an_arch_between_its_materials() {
        let found = Boundaries::new(&ball(), usize::MAX);
        // Mean row at either material's value and between them.
        let height = |value: f64| {
            let middle = bin(value / 255.0, VALUES);
            let near =
                (middle - 4..=middle + 4).flat_map(|column| (0..MAGNITUDES).map(move |row| (row, column)));
            let (mut all, mut sum) = (0.0, 0.0);
            for (row, column) in near {
                let count = f64::from(found.counts[row * VALUES + column]);
                (all, sum) = (all + count, sum + count * row as f64);
            }
            sum / all
        };
        assert!(height(120.0) > 1.3 * height(50.0) && height(120.0) > 1.3 * height(192.0));
    }

    #[test]
    fn large_volumes_are_counted_in_part_and_flat_ones_too() {
        let grid = Grid::new([32; 3], [1.0; 3]).unwrap();
        let flat = Volume::from_values(grid, vec![7u8; 32 * 32 * 32]).unwrap();
        let found = Boundaries::new(&flat, 4096);
        assert_eq!((found.counts.iter().sum::<u32>(), found.most), (4096, 0.0));
        assert_eq!(found.counts[7], 4096);
        let brightest = found.brightness().fold(0.0, f32::max);
        assert!((brightest - 1.0).abs() < 1e-6);
    }
}
