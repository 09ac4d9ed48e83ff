use crate::{ClipPlanes, Error, Grid, Result};
use glam::DVec3;

/// Crop box of a volume, cut by planes: rays see only the part inside it.
///
/// Corners are positions of [`Grid::world_to_grid`], in which voxel *i* covers [i, i+1]. They may lie anywhere within
/// voxels. Interpolation near the faces still uses the voxels beyond them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClipBox {
    low: DVec3,
    high: DVec3,
    planes: ClipPlanes,
}

impl ClipBox {
    /// Box around all of `grid`.
    pub fn whole(grid: &Grid) -> Self {
        let [x, y, z] = grid.dims();
        Self {
            low: DVec3::ZERO,
            high: DVec3::new(x as f64, y as f64, z as f64),
            planes: ClipPlanes::default(),
        }
    }

    /// Box from the corner `low` to the corner `high` of `grid`.
    ///
    /// # Errors
    /// Corners outside the grid, or an empty box.
    pub fn new(low: DVec3, high: DVec3, grid: &Grid) -> Result<Self> {
        let whole = Self::whole(grid).high;
        if low.cmpge(DVec3::ZERO).all() && low.cmplt(high).all() && high.cmple(whole).all() {
            return Ok(Self { low, high, planes: ClipPlanes::default() });
        }
        Err(Error::Extent {
            what: "clip box".into(),
            found: format!("({} {} {}) to ({} {} {})", low.x, low.y, low.z, high.x, high.y, high.z),
            expected: format!("rising within 0 and ({} {} {}) voxels", whole.x, whole.y, whole.z),
        })
    }

    /// This box, cut by `planes` in the world space of the grid.
    #[must_use]
    pub fn with_planes(self, planes: ClipPlanes) -> Self {
        Self { planes, ..self }
    }

    /// Planes that cut the box, in the world space of the grid.
    pub fn planes(&self) -> &ClipPlanes {
        &self.planes
    }

    /// Lowest and highest corner in the world space of `grid`.
    pub fn in_world(&self, grid: &Grid) -> [DVec3; 2] {
        let half = grid.world_extent() * 0.5;
        let whole = Self::whole(grid);
        // Faces of the grid stay exact, without rounding errors.
        let low = DVec3::select(self.low.cmpeq(whole.low), -half, grid.grid_to_world(self.low));
        let high = DVec3::select(self.high.cmpeq(whole.high), half, grid.grid_to_world(self.high));
        [low, high]
    }

    /// Lowest and highest corner in voxel-centre coordinates (voxel *i* at *i*).
    pub fn in_voxels(&self) -> [[f32; 3]; 2] {
        [self.low, self.high].map(|corner| (corner - 0.5).as_vec3().to_array())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_whole_grid_ends_at_its_faces() {
        let grid = Grid::new([7, 30, 11], [0.3, 1.1, 0.7]).unwrap();
        let half = grid.world_extent() * 0.5;
        let whole = ClipBox::whole(&grid);
        assert_eq!(whole.in_world(&grid), [-half, half]);
        assert_eq!(whole.in_voxels(), [[-0.5; 3], [6.5, 29.5, 10.5]]);
    }

    #[test]
    fn parts_lie_where_their_corners_do() {
        let grid = Grid::new([10, 20, 5], [1.0, 0.5, 2.0]).unwrap();
        let (low, high) = (DVec3::new(2.25, 0.0, 1.0), DVec3::new(2.5, 20.0, 4.9));
        let part = ClipBox::new(low, high, &grid).unwrap();
        let [from, to] = part.in_world(&grid);
        assert!((from - DVec3::new(-0.275, -0.5, -0.3)).length() < 1e-12, "{from}");
        assert!((to - DVec3::new(-0.25, 0.5, 0.48)).length() < 1e-12, "{to}");
        assert_eq!(part.in_voxels()[0], [1.75, -0.5, 0.5]);
    }

    #[test]
    fn parts_that_are_none_are_refused() {
        let grid = Grid::new([4; 3], [1.0; 3]).unwrap();
        let (one, two) = (DVec3::ONE, DVec3::splat(2.0));
        for (low, high) in [(two, one), (one, one), (-one, one), (one, two * 3.0), (one, two * f64::NAN)] {
            let error = ClipBox::new(low, high, &grid).unwrap_err().to_string();
            assert!(error.contains("within 0 and (4 4 4)"), "{error}");
        }
    }
}
