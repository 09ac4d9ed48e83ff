//! Lengths of the gradients of a volume.

use super::brick_layout::BRICK;
use super::bricks::{BrickData, Bricks};
use fovol_core::Grid;
use fovol_core::memory::Shortage;

/// Greatest length that a gradient of display values can have on `grid`, per mean edge of a voxel.
pub fn greatest_gradient(grid: &Grid) -> f64 {
    weights(grid).iter().map(|weight| weight * weight).sum::<f64>().sqrt()
}

/// Factors from differences over ±1 voxel to derivatives along x, y and z, per mean edge of a voxel.
fn weights(grid: &Grid) -> [f64; 3] {
    let edges = grid.voxel_size().to_array();
    let mean = edges.iter().sum::<f64>() / 3.0;
    edges.map(|edge| 0.5 * mean / edge)
}

impl Bricks {
    /// Lengths of the gradients of the display values of these bricks, which lie on `grid`.
    ///
    /// Every voxel has the length of its central differences over ±1 voxel in world units, per mean edge of a voxel.
    /// Beyond the edge of the grid the last voxel repeats, and so does a voxel beside NaN. The lengths are in 16 bits;
    /// the highest stands for the longest gradient that there can be.
    ///
    /// # Errors
    /// Too little memory.
    pub fn gradient_lengths(&self, grid: &Grid) -> Result<Self, Shortage> {
        let dims = grid.dims();
        let weights = weights(grid).map(|weight| weight as f32);
        let greatest = greatest_gradient(grid) as f32;
        let unit = f32::from(u16::MAX) / greatest;
        let mut lengths = Self::of_lines(dims, BrickData::U16, unit.recip(), |voxel, line: &mut [u16]| {
            let mut rows = Rows::around(self, dims, voxel, line.len());
            if self.has_gaps() {
                rows.close_gaps();
            }
            let found = rows.gradients(weights.map(|weight| weight * unit));
            line.iter_mut().zip(found).for_each(|(length, found)| *length = (found + 0.5) as u16);
        })?;
        lengths.set_interpolation(self.interpolation());
        Ok(lengths)
    }

    /// Memory of the [lengths of gradients](Self::gradient_lengths) of a volume of `dims` voxels, in bytes.
    pub fn bytes_of_gradient_lengths(dims: [usize; 3]) -> u64 {
        (super::BrickLayout::voxels(dims).elements() * size_of::<u16>()) as u64
    }
}

/// Voxels of a line of bricks, with one more on both sides.
type Row = [f32; BRICK + 3];

/// Neighbours of a line of voxels.
struct Rows {
    /// The line itself, from one voxel before it.
    own: Row,
    /// Before and after along x, y and z.
    neighbours: [[[f32; BRICK + 1]; 2]; 3],
}

impl Rows {
    /// The `length` voxels of `bricks` along x from `voxel` on.
    fn around(bricks: &Bricks, dims: [usize; 3], voxel: [usize; 3], length: usize) -> Self {
        let [x, ..] = voxel;
        let put = |voxel, row: &mut [f32]| bricks.put_line(voxel, 0, bricks.scale(), row);
        let mut own = [0.0; BRICK + 3];
        let from = x.saturating_sub(1);
        let to = (x + length + 1).min(dims[0]);
        let first = usize::from(x == 0);
        put([from, voxel[1], voxel[2]], &mut own[first..first + to - from]);
        if x == 0 {
            own[0] = own[1];
        }
        if x + length == dims[0] {
            own[length + 1] = own[length];
        }
        let [mut before, mut after] = [[0.0; BRICK + 1]; 2];
        before.copy_from_slice(&own[..=BRICK]);
        after.copy_from_slice(&own[2..]);
        let beside = |axis: usize| {
            let [mut before, mut after] = [voxel, voxel];
            before[axis] = voxel[axis].saturating_sub(1);
            after[axis] = (voxel[axis] + 1).min(dims[axis] - 1);
            [before, after].map(|voxel| {
                let mut row = [0.0; BRICK + 1];
                put(voxel, &mut row[..length]);
                row
            })
        };
        Self { own, neighbours: [[before, after], beside(1), beside(2)] }
    }

    /// Puts voxels in the place of their neighbours that are NaN. Voxels that are NaN get no gradient.
    fn close_gaps(&mut self) {
        for row in self.neighbours.iter_mut().flatten() {
            for (neighbour, here) in row.iter_mut().zip(&self.own[1..]) {
                if neighbour.is_nan() || here.is_nan() {
                    *neighbour = if here.is_nan() { 0.0 } else { *here };
                }
            }
        }
    }

    /// Lengths of the gradients of all voxels of the line.
    #[inline]
    fn gradients(&self, [along_x, along_y, along_z]: [f32; 3]) -> [f32; BRICK + 1] {
        let [[x0, x1], [y0, y1], [z0, z1]] = &self.neighbours;
        std::array::from_fn(|i| {
            let (x, y, z) = (x1[i] - x0[i], y1[i] - y0[i], z1[i] - z0[i]);
            let [x, y, z] = [x * along_x, y * along_y, z * along_z];
            (x * x + y * y + z * z).sqrt()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovol_core::Volume;

    #[test]
    fn lengths_are_central_differences_in_world_units() {
        let grid = Grid::new([19, 10, 17], [1.0, 2.0, 0.5]).unwrap();
        let value = |i: usize| (i * 37 % 251) as f32;
        let plain: Vec<f32> = (0..grid.voxels()).map(value).collect();
        let gaps: Vec<f32> =
            (0..grid.voxels()).map(|i| if i % 7 == 3 { f32::NAN } else { value(i) }).collect();
        let bytes: Vec<u8> = plain.iter().map(|v| *v as u8).collect();
        for volume in [
            Volume::from_values(grid, plain).unwrap(),
            Volume::from_values(grid, gaps).unwrap(),
            Volume::from_values(grid, bytes).unwrap(),
        ] {
            let bricks = Bricks::of_volume(&volume).unwrap();
            let lengths = bricks.gradient_lengths(&grid).unwrap();
            let step = lengths.scale();
            assert!((f64::from(step) * 65535.0 / greatest_gradient(&grid) - 1.0).abs() < 1e-6);
            let mean = 3.5 / 3.0;
            for i in 0..grid.voxels() {
                let voxel = [i % 19, i / 19 % 10, i / 190];
                let here = bricks.voxel(voxel);
                let squared: f32 = (0..3)
                    .map(|a| {
                        let at = |offset: isize| {
                            let mut other = voxel;
                            let last = grid.dims()[a] as isize - 1;
                            other[a] = (voxel[a] as isize + offset).clamp(0, last) as usize;
                            let value = bricks.voxel(other);
                            if value.is_nan() { here } else { value }
                        };
                        let slope = (at(1) - at(-1)) / (2.0 * [1.0, 2.0, 0.5][a] / mean);
                        slope * slope
                    })
                    .sum();
                let expected = if here.is_nan() { 0.0 } else { squared.sqrt() };
                let found = lengths.voxel(voxel);
                assert!((found - expected).abs() <= 0.6 * step, "{voxel:?}: {found} {expected}");
            }
        }
    }

    #[test]
    fn flat_volumes_have_no_gradient() {
        let grid = Grid::new([1, 1, 9], [1.0; 3]).unwrap();
        let bricks = Bricks::of_volume(&Volume::from_values(grid, vec![3u8; 9]).unwrap()).unwrap();
        let lengths = bricks.gradient_lengths(&grid).unwrap();
        assert!((0..9).all(|z| lengths.voxel([0, 0, z]) == 0.0));
    }
}
