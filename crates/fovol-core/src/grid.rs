use crate::{Error, Result};
use glam::DVec3;

/// Largest accepted number of voxels along one axis.
pub const MAX_DIM: usize = 1 << 16;

/// Regular grid of a volume: voxel counts and spacing.
///
/// Voxel *i* covers [i, i+1]; its value lies at its centre.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grid {
    dims: [usize; 3],
    spacing: [f64; 3],
}

impl Grid {
    /// Grid of `dims` voxels (x, y, z; 1…65536 each) at `spacing` (any unit, positive).
    ///
    /// # Errors
    /// A dimension of zero or above [`MAX_DIM`]; a spacing that is not finite and positive.
    pub fn new(dims: [usize; 3], spacing: [f64; 3]) -> Result<Self> {
        if dims.iter().any(|&d| d == 0 || d > MAX_DIM) {
            return Err(Error::Extent {
                what: "volume size".into(),
                found: format!("{}x{}x{}", dims[0], dims[1], dims[2]),
                expected: format!("1 to {MAX_DIM} voxels along each axis"),
            });
        }
        for s in spacing {
            crate::checked("spacing", s, "a finite number above 0", s > 0.0)?;
        }
        Ok(Self { dims, spacing })
    }

    /// Number of voxels along x, y, z.
    pub fn dims(&self) -> [usize; 3] {
        self.dims
    }

    /// Distance between voxel centres along x, y, z, in the unit of the file.
    pub fn spacing(&self) -> [f64; 3] {
        self.spacing
    }

    /// Number of voxels. At most 2⁴⁸, so it never overflows on a 64-bit machine.
    pub fn voxels(&self) -> usize {
        self.dims.iter().product()
    }

    /// Extent of the box in world units; the longest side is 1.
    pub fn world_extent(&self) -> DVec3 {
        self.physical_extent() * self.world_scale()
    }

    /// Edge lengths of one voxel in world units.
    pub fn voxel_size(&self) -> DVec3 {
        DVec3::from_array(self.spacing) * self.world_scale()
    }

    /// Smallest spacing in world units: the reference length of opacity and of the step.
    pub fn smallest_voxel(&self) -> f64 {
        self.voxel_size().min_element()
    }

    /// Converts a world position to a continuous grid position, in which voxel *i* covers [i, i+1].
    pub fn world_to_grid(&self, world: DVec3) -> DVec3 {
        (world + self.world_extent() * 0.5) / self.voxel_size()
    }

    /// Converts a continuous grid position to a world position: the inverse of [`Self::world_to_grid`].
    pub fn grid_to_world(&self, grid: DVec3) -> DVec3 {
        grid * self.voxel_size() - self.world_extent() * 0.5
    }

    fn physical_extent(&self) -> DVec3 {
        let [x, y, z] = self.dims;
        DVec3::new(x as f64, y as f64, z as f64) * DVec3::from_array(self.spacing)
    }

    fn world_scale(&self) -> f64 {
        1.0 / self.physical_extent().max_element()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_longest_side_is_one_and_the_box_is_centred() {
        let grid = Grid::new([128, 64, 32], [1.0, 1.0, 3.0]).unwrap();
        assert_eq!(grid.world_extent(), DVec3::new(1.0, 0.5, 0.75));
        assert_eq!(grid.smallest_voxel(), 1.0 / 128.0);
        assert_eq!(grid.grid_to_world(DVec3::new(64.0, 32.0, 16.0)), DVec3::ZERO);
    }

    #[test]
    fn absurd_grids_are_refused() {
        for dims in [[0, 1, 1], [1, 1, 100_000]] {
            assert!(Grid::new(dims, [1.0; 3]).is_err());
        }
        for spacing in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(Grid::new([2, 2, 2], [1.0, spacing, 1.0]).is_err());
        }
    }

    proptest! {
        #[test]
        fn grid_and_world_are_inverse(
            dims in prop::array::uniform3(1usize..500),
            spacing in prop::array::uniform3(0.01f64..10.0),
            p in prop::array::uniform3(-1.0f64..1.0),
        ) {
            let grid = Grid::new(dims, spacing).unwrap();
            let p = DVec3::from_array(p);
            prop_assert!((grid.grid_to_world(grid.world_to_grid(p)) - p).length() < 1e-12);
        }
    }
}
