//! Rulers: measured lengths.

use super::orientation::Plane;
use fovolnet::core::{Grid, Volume};
use glam::DVec3;

/// Length between two points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ruler {
    /// Ends, as continuous voxel numbers with integers at voxel centres.
    pub ends: [DVec3; 2],
    /// Plane of the slice in which it was measured; `None` for the 3-D picture.
    pub plane: Option<Plane>,
}

impl Ruler {
    /// Length in the unit of the spacing. The axes of `volume` may be sheared, if its file says so.
    pub fn length(&self, volume: &Volume) -> f64 {
        let [from, to] = self.ends;
        match volume.placement() {
            Some(placement) => {
                let [from, to] = [from, to].map(|end| placement.position(end, volume.grid()));
                (to - from).length()
            }
            None => ((to - from) * DVec3::from_array(volume.grid().spacing())).length(),
        }
    }
}

/// Unit of lengths in `grid`, whose file declares the `units` of its spacing, if any.
pub fn unit_of_length<'a>(grid: &Grid, units: Option<&'a str>) -> &'a str {
    units.unwrap_or(if grid.spacing() == [1.0; 3] { "voxels" } else { "units" })
}

/// All rulers, and the one that is being drawn.
#[derive(Debug, Clone, Default)]
pub struct Rulers {
    done: Vec<Ruler>,
    begun: Option<Ruler>,
}

impl Rulers {
    /// Begins a ruler at `from` in the slice of `plane`, or in the 3-D picture.
    pub fn begin(&mut self, from: DVec3, plane: Option<Plane>) {
        self.begun = Some(Ruler { ends: [from; 2], plane });
    }

    /// Moves the other end of the ruler that is being drawn in `plane`.
    pub fn draw_to(&mut self, to: DVec3, plane: Option<Plane>) {
        if let Some(ruler) = self.begun.as_mut().filter(|ruler| ruler.plane == plane) {
            ruler.ends[1] = to;
        }
    }

    /// Keeps the ruler that is being drawn. A click alone measures nothing.
    pub fn end(&mut self) {
        self.done.extend(self.begun.take().filter(|ruler| ruler.ends[0] != ruler.ends[1]));
    }

    /// Whether the ruler that is being drawn is in `plane`.
    pub fn draws_in(&self, plane: Option<Plane>) -> bool {
        self.begun.is_some_and(|ruler| ruler.plane == plane)
    }

    /// Removes all.
    pub fn clear(&mut self) {
        *self = Self::default();
    }

    /// All rulers, the one that is being drawn last.
    pub fn iter(&self) -> impl Iterator<Item = &Ruler> {
        self.done.iter().chain(&self.begun)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovolnet::core::{Placement, Space};
    use glam::DMat3;

    fn volume() -> Volume {
        let grid = Grid::new([4, 4, 4], [0.5, 2.0, 3.0]).unwrap();
        Volume::from_values(grid, vec![0u8; 64]).unwrap()
    }

    fn ruler(from: [f64; 3], to: [f64; 3]) -> Ruler {
        Ruler { ends: [from, to].map(DVec3::from_array), plane: None }
    }

    #[test]
    fn lengths_have_the_unit_of_the_spacing() {
        let diagonal = ruler([0.0, 1.0, 1.0], [6.0, 3.0, 1.0]);
        assert_eq!(diagonal.length(&volume()), 5.0);
        let turned = DMat3::from_cols(DVec3::NEG_Y, DVec3::X, DVec3::Z);
        let turned = volume().with_placement(Placement::new(turned, DVec3::ONE, Space::Patient).unwrap());
        assert!((diagonal.length(&turned) - 5.0).abs() < 1e-12);
        // A gantry tilt leans z along y.
        let tilted = DMat3::from_cols(DVec3::X, DVec3::Y, DVec3::new(0.0, 0.6, 0.8));
        let tilted = volume().with_placement(Placement::new(tilted, DVec3::ZERO, Space::Patient).unwrap());
        let along = ruler([0.0, 0.0, 0.0], [0.0, 1.0, 1.0]);
        assert!((along.length(&tilted) - (3.8f64 * 3.8 + 2.4 * 2.4).sqrt()).abs() < 1e-12);
    }

    #[test]
    fn rulers_stay_until_they_are_cleared() {
        let mut rulers = Rulers::default();
        for to in [DVec3::X, DVec3::Y] {
            rulers.begin(DVec3::ZERO, Some(Plane::Axial));
            rulers.draw_to(DVec3::ONE, Some(Plane::Coronal));
            rulers.draw_to(to, Some(Plane::Axial));
            assert!(rulers.draws_in(Some(Plane::Axial)) && !rulers.draws_in(None));
            rulers.end();
        }
        let ends: Vec<DVec3> = rulers.iter().map(|ruler| ruler.ends[1]).collect();
        assert_eq!(ends, [DVec3::X, DVec3::Y]);
        rulers.begin(DVec3::ZERO, None);
        rulers.end();
        assert_eq!(rulers.iter().count(), 2, "a click is no length");
        rulers.clear();
        assert_eq!(rulers.iter().count(), 0);
    }

    #[test]
    fn lengths_without_a_unit_are_voxels_or_units() {
        let grid = |spacing| Grid::new([1; 3], spacing).unwrap();
        assert_eq!(unit_of_length(&grid([1.0; 3]), Some("mm")), "mm");
        assert_eq!(unit_of_length(&grid([1.0; 3]), None), "voxels");
        assert_eq!(unit_of_length(&grid([1.0, 1.0, 2.0]), None), "units");
    }
}
