use super::seeded::mix;
use bytemuck::Zeroable;
use fovol_core::{Grid, Result, memory, stop};
use glam::Vec3;
use rayon::prelude::*;

/// Advice for volumes that do not fit in memory.
pub const FEWER_VOXELS: &str = "smaller --dims need less";

/// The cube [−1, 1]³ seen through a grid.
pub(super) struct Domain {
    grid: Grid,
    seed: u64,
}

/// One voxel: its number along each axis and its centre.
#[derive(Clone, Copy)]
pub(super) struct Site {
    pub index: [usize; 3],
    pub centre: Vec3,
}

impl Domain {
    /// The cube with `dims` voxels along its edges; the shortest edge of a voxel is the unit of the spacing.
    pub fn new(dims: [usize; 3], seed: u64) -> Result<Self> {
        let longest = dims[0].max(dims[1]).max(dims[2]) as f64;
        let grid = Grid::new(dims, dims.map(|side| longest / side as f64))?;
        Ok(Self { grid, seed })
    }

    pub fn grid(&self) -> Grid {
        self.grid
    }

    /// A seed for one of several random parts of a volume.
    pub fn seed(&self, part: u32) -> u64 {
        mix(self.seed ^ mix(u64::from(part) + 1))
    }

    /// The shortest edge of a voxel, in units of the cube.
    pub fn voxel(&self) -> f32 {
        let [x, y, z] = self.grid.dims();
        2.0 / x.max(y).max(z) as f32
    }

    /// The centres of the voxels along `axis`.
    pub fn centres(&self, axis: usize) -> Vec<f32> {
        let side = self.grid.dims()[axis];
        (0..side).map(|i| ((i as f32 + 0.5) / side as f32) * 2.0 - 1.0).collect()
    }

    /// Zeros for every voxel.
    pub fn zeros<T: Zeroable>(&self) -> Result<Vec<T>> {
        Ok(memory::zeroed(self.grid.voxels(), "the voxels", FEWER_VOXELS)?)
    }

    /// `value` at every voxel, x fastest.
    pub fn sample<T: Send + Copy + Zeroable>(&self, value: impl Fn(Site) -> T + Sync) -> Result<Vec<T>> {
        let [nx, ny, _] = self.grid.dims();
        let [xs, ys, zs] = [0, 1, 2].map(|axis| self.centres(axis));
        let mut values = self.zeros()?;
        for_each_row(&mut values, nx, &|row, out| {
            let (y, z) = (row % ny, row / ny);
            for (x, out) in out.iter_mut().enumerate() {
                *out = value(Site { index: [x, y, z], centre: Vec3::new(xs[x], ys[y], zs[z]) });
            }
        });
        Ok(values)
    }
}

/// Calls `fill` with the number and the values of each row of `length`, on all threads.
///
/// Not generic over `fill`: what distributes the work is large, and compiled once for all volumes.
fn for_each_row<T: Send>(values: &mut [T], length: usize, fill: &(dyn Fn(usize, &mut [T]) + Sync)) {
    values.par_chunks_mut(length).enumerate().for_each(|(row, out)| {
        stop::point();
        fill(row, out);
    });
}
