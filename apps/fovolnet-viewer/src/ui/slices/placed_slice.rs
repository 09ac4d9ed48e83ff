//! Mapping between a slice on the screen and voxels.

use super::orientation::{Lie, Way};
use eframe::egui::{Pos2, Rect, vec2};
use fovolnet::core::Grid;
use glam::DVec3;

/// Picture of a slice in its place on the screen. Voxels are continuous numbers with integers at voxel centres.
#[derive(Debug, Clone, Copy)]
pub struct PlacedSlice {
    /// How the picture lies in the grid.
    pub lie: Lie,
    /// Rectangle of the picture.
    pub rect: Rect,
    /// Points for each unit of the grid's spacing.
    pub points_a_unit: f64,
    dims: [usize; 3],
}

impl PlacedSlice {
    /// Largest picture of a slice of `grid` in the middle of `room`, with the grid's proportions.
    pub fn new(lie: Lie, grid: &Grid, room: Rect) -> Self {
        let side = |way: Way| grid.dims()[way.axis] as f64 * grid.spacing()[way.axis];
        let (width, height) = (side(lie.right), side(lie.down));
        let points_a_unit = (f64::from(room.width()) / width).min(f64::from(room.height()) / height).max(0.0);
        let size = vec2((width * points_a_unit) as f32, (height * points_a_unit) as f32);
        Self { lie, rect: Rect::from_center_size(room.center(), size), points_a_unit, dims: grid.dims() }
    }

    /// Voxel at the point `at` of the screen, in slice `number`. It may lie outside the grid.
    pub fn voxel(&self, at: Pos2, number: usize) -> DVec3 {
        let part = (at - self.rect.min) / self.rect.size();
        let mut voxel = DVec3::ZERO;
        for (way, part) in [(self.lie.right, part.x), (self.lie.down, part.y)] {
            let dim = self.dims[way.axis] as f64;
            let along = f64::from(part) * dim;
            voxel[way.axis] = if way.rises { along - 0.5 } else { dim - 0.5 - along };
        }
        voxel[self.lie.across.axis] = number as f64;
        voxel
    }

    /// Point of the screen at `voxel`, whatever its slice.
    pub fn point(&self, voxel: DVec3) -> Pos2 {
        let part = |way: Way| {
            let dim = self.dims[way.axis] as f64;
            let along = (voxel[way.axis] + 0.5) / dim;
            (if way.rises { along } else { 1.0 - along }) as f32
        };
        self.rect.min + vec2(part(self.lie.right), part(self.lie.down)) * self.rect.size()
    }
}

/// The voxel that holds the position `voxel`; `None` outside a grid of `dims`.
pub fn within(voxel: DVec3, dims: [usize; 3]) -> Option<[usize; 3]> {
    let nearest = voxel.round();
    let is_inside = (0..3).all(|a| nearest[a] >= 0.0 && nearest[a] < dims[a] as f64);
    is_inside.then(|| nearest.to_array().map(|along| along as usize))
}

/// The voxel of a grid of `dims` nearest to the position `voxel`.
pub fn nearest(voxel: DVec3, dims: [usize; 3]) -> [usize; 3] {
    std::array::from_fn(|a| voxel[a].round().clamp(0.0, (dims[a] - 1) as f64) as usize)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ui::slices::orientation::Plane;
    use eframe::egui::pos2;
    use fovolnet::core::{Placement, Space};
    use glam::DMat3;

    fn axial() -> PlacedSlice {
        let axes = DMat3::from_cols(DVec3::NEG_X, DVec3::NEG_Y, DVec3::Z);
        let placement = Placement::new(axes, DVec3::ZERO, Space::Patient).unwrap();
        let grid = Grid::new([4, 3, 2], [1.0, 2.0, 5.0]).unwrap();
        let room = Rect::from_min_size(pos2(10.0, 20.0), vec2(80.0, 60.0));
        PlacedSlice::new(Lie::new(Plane::Axial, Some(&placement)), &grid, room)
    }

    #[test]
    fn slices_have_the_proportions_of_the_grid() {
        let slice = axial();
        // 4 units wide and 6 high: ten points for each.
        assert_eq!(slice.points_a_unit, 10.0);
        assert_eq!(slice.rect, Rect::from_min_size(pos2(30.0, 20.0), vec2(40.0, 60.0)));
    }

    #[test]
    fn points_and_voxels_are_inverse() {
        let slice = axial();
        // The grid's x rises to the right hand, which is on the left.
        let near = |a: DVec3, b: DVec3| a.abs_diff_eq(b, 1e-6);
        assert!(near(slice.voxel(pos2(35.0, 30.0), 1), DVec3::new(3.0, 2.0, 1.0)));
        assert!(near(slice.voxel(pos2(65.0, 70.0), 0), DVec3::ZERO));
        for at in [pos2(31.0, 22.0), pos2(44.0, 77.0)] {
            assert!((slice.point(slice.voxel(at, 1)) - at).length() < 1e-4);
        }
    }

    #[test]
    fn voxels_reach_half_a_voxel_around_their_centres() {
        let dims = [4, 3, 2];
        assert_eq!(within(DVec3::new(-0.4, 2.4, 1.0), dims), Some([0, 2, 1]));
        assert_eq!(within(DVec3::new(-0.6, 2.4, 1.0), dims), None);
        assert_eq!(within(DVec3::new(0.0, 2.6, 1.0), dims), None);
        assert_eq!(nearest(DVec3::new(-9.0, 1.2, 7.0), dims), [0, 1, 1]);
    }
}
