use crate::{Error, Grid, Result};
use glam::{DMat3, DVec3};

/// Coordinate space in which a file places its grid.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Space {
    /// Patient space. The file's axes mean left, posterior and superior, whatever it calls them.
    Patient,
    /// Other space; its axes are called left, posterior and superior where they must be named.
    Other,
}

/// Position of a grid in the space of its file: directions of the voxel axes and position of the first voxel.
///
/// Coordinates are LPS: x grows to the patient's left, y to the back (posterior), z to the head (superior). DICOM and
/// ITK use these axes; NIfTI's x and y point the other way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placement {
    directions: DMat3,
    origin: DVec3,
    space: Space,
}

/// Largest cosine between axes that count as orthogonal, since files round their directions.
const SQUARE: f64 = 2e-3;

/// Rotation from LPS to world space, where +x is left, +y superior and +z anterior.
const WORLD_FROM_LPS: DMat3 = DMat3::from_cols(DVec3::X, DVec3::NEG_Z, DVec3::Y);

impl Placement {
    /// Placement with voxel axes along the columns of `directions` (LPS, any length) and the centre of the first
    /// voxel at `origin` (LPS, in the unit of the file).
    ///
    /// # Errors
    /// Numbers that are not finite, axes without a length, axes that lie in one plane.
    pub fn new(directions: DMat3, origin: DVec3, space: Space) -> Result<Self> {
        let bad = |found: String| Error::Extent {
            what: "orientation".into(),
            found,
            expected: "three finite axes that span space".into(),
        };
        let columns = [directions.x_axis, directions.y_axis, directions.z_axis];
        let shown = columns.map(|axis| format!("({} {} {})", axis.x, axis.y, axis.z)).join(" ");
        let Some([x, y, z]) = normalised(columns) else { return Err(bad(shown)) };
        let directions = DMat3::from_cols(x, y, z);
        if !origin.is_finite() || directions.determinant().abs() < 1e-3 {
            return Err(bad(format!("{shown} at ({} {} {})", origin.x, origin.y, origin.z)));
        }
        Ok(Self { directions, origin, space })
    }

    /// Unit vectors along the voxel axes x, y, z as columns, in LPS.
    pub fn directions(&self) -> DMat3 {
        self.directions
    }

    /// Centre of the first voxel in LPS, in the unit of the file.
    pub fn origin(&self) -> DVec3 {
        self.origin
    }

    /// Kind of space.
    pub fn space(&self) -> Space {
        self.space
    }

    /// Placement of a part of `grid` whose first voxel is at the continuous index `voxel`.
    #[must_use]
    pub fn moved_to(&self, voxel: DVec3, grid: &Grid) -> Self {
        let way = voxel * DVec3::from_array(grid.spacing());
        Self { origin: self.origin + self.directions * way, ..*self }
    }

    /// LPS position of `voxel`, a continuous index with integers at voxel centres.
    pub fn position(&self, voxel: DVec3, grid: &Grid) -> DVec3 {
        self.moved_to(voxel, grid).origin
    }

    /// Anatomical letters of the directions of voxel axes x, y, z: each L, P, S or R, A, I.
    pub fn letters(&self) -> String {
        let mut letters = ['?'; 3];
        let mut taken = [false; 3];
        let turned = nearest_orthogonal(self.directions);
        let mut order = [0, 1, 2];
        let greatest = |axis: usize| turned.col(axis).abs().max_element();
        order.sort_by(|&a, &b| greatest(b).total_cmp(&greatest(a)));
        for axis in order {
            let column = turned.col(axis);
            let open = (0..3).filter(|&row| !taken[row]);
            let Some(row) = open.max_by(|&a, &b| column[a].abs().total_cmp(&column[b].abs())) else {
                continue;
            };
            taken[row] = true;
            letters[axis] = if column[row] > 0.0 { ['L', 'P', 'S'][row] } else { ['R', 'A', 'I'][row] };
        }
        letters.iter().collect()
    }

    /// Whether the voxel axes are left-handed, that is, mirrored against the space.
    pub fn is_left_handed(&self) -> bool {
        self.directions.determinant() < 0.0
    }

    /// Largest deviation from a right angle between two voxel axes, in degrees. 0 for deviations from rounding only.
    /// A gantry tilt produces sheared grids.
    pub fn shear(&self) -> f64 {
        let DMat3 { x_axis: x, y_axis: y, z_axis: z } = self.directions;
        let cosine = [x.dot(y), y.dot(z), z.dot(x)].into_iter().map(f64::abs).fold(0.0, f64::max);
        if cosine < SQUARE { 0.0 } else { cosine.min(1.0).asin().to_degrees() }
    }

    /// Rotation from the grid's box to world space, in which the patient stands upright and looks along +z. An
    /// orthogonal matrix, with determinant −1 for mirrored grids. Sheared axes are replaced by the nearest orthogonal
    /// ones.
    pub fn world_from_box(&self) -> DMat3 {
        let turned = WORLD_FROM_LPS * nearest_orthogonal(self.directions);
        // Files hold rounded numbers; rotations by quarter turns are made exact.
        let whole = DMat3::from_cols_array(&turned.to_cols_array().map(f64::round));
        let is_whole = turned.abs_diff_eq(whole, 1e-6);
        if is_whole { whole } else { turned }
    }
}

/// Normalises `columns` to length 1; `None` if one has no length or is not finite.
fn normalised(columns: [DVec3; 3]) -> Option<[DVec3; 3]> {
    let [x, y, z] = columns.map(DVec3::try_normalize);
    Some([x?, y?, z?])
}

/// Orthogonal matrix nearest to the regular `matrix`: polar decomposition by Newton's iteration (Higham 1986).
fn nearest_orthogonal(matrix: DMat3) -> DMat3 {
    let mut turned = matrix;
    for _ in 0..60 {
        let next = (turned + turned.inverse().transpose()) * 0.5;
        let is_done = next.abs_diff_eq(turned, 1e-15);
        turned = next;
        if is_done {
            break;
        }
    }
    turned
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn placed(columns: [DVec3; 3]) -> Placement {
        let [x, y, z] = columns;
        Placement::new(DMat3::from_cols(x, y, z), DVec3::ZERO, Space::Patient).unwrap()
    }

    #[test]
    fn letters_say_where_axes_point() {
        assert_eq!(placed([DVec3::X, DVec3::Y, DVec3::Z]).letters(), "LPS");
        assert_eq!(placed([DVec3::NEG_X, DVec3::NEG_Y, DVec3::Z]).letters(), "RAS");
        assert_eq!(placed([DVec3::NEG_Z, DVec3::X, DVec3::NEG_Y]).letters(), "ILA");
        let oblique = [DVec3::new(1.0, 0.3, 0.1), DVec3::new(-0.3, 1.0, 0.2), DVec3::new(0.0, -0.2, 1.0)];
        assert_eq!(placed(oblique).letters(), "LPS");
    }

    #[test]
    fn the_patient_stands_upright_and_looks_at_the_camera() {
        let world = placed([DVec3::X, DVec3::Y, DVec3::Z]).world_from_box();
        // Left is +x, superior +y, anterior +z.
        assert_eq!(world * DVec3::X, DVec3::X);
        assert_eq!(world * DVec3::NEG_Y, DVec3::Z);
        assert_eq!(world * DVec3::Z, DVec3::Y);
        assert_eq!(world.determinant(), 1.0);
    }

    #[test]
    fn mirrored_grids_are_known() {
        let las = placed([DVec3::X, DVec3::NEG_Y, DVec3::Z]);
        assert!(las.is_left_handed());
        assert_eq!(las.world_from_box().determinant(), -1.0);
        assert!(!placed([DVec3::NEG_X, DVec3::NEG_Y, DVec3::Z]).is_left_handed());
    }

    #[test]
    fn shear_is_measured_and_taken_out() {
        let tilt = 12f64.to_radians();
        let tilted = placed([DVec3::X, DVec3::Y, DVec3::new(0.0, tilt.sin(), tilt.cos())]);
        assert!((tilted.shear() - 12.0).abs() < 1e-9);
        let turned = tilted.world_from_box();
        assert!((turned * turned.transpose()).abs_diff_eq(DMat3::IDENTITY, 1e-12));
        assert_eq!(placed([DVec3::new(1.0, 1e-4, 0.0), DVec3::Y, DVec3::Z]).shear(), 0.0);
    }

    #[test]
    fn what_spans_no_space_is_refused() {
        for columns in [
            [DVec3::X, DVec3::X, DVec3::Z],
            [DVec3::ZERO, DVec3::Y, DVec3::Z],
            [DVec3::NAN, DVec3::Y, DVec3::Z],
        ] {
            let [x, y, z] = columns;
            assert!(Placement::new(DMat3::from_cols(x, y, z), DVec3::ZERO, Space::Other).is_err());
        }
        assert!(Placement::new(DMat3::IDENTITY, DVec3::INFINITY, Space::Other).is_err());
    }

    proptest! {
        #[test]
        fn turns_are_orthogonal_and_keep_handedness(
            entries in prop::array::uniform9(-1.0f64..1.0),
        ) {
            let matrix = DMat3::from_cols_array(&entries);
            prop_assume!(matrix.determinant().abs() > 0.05);
            let placement = Placement::new(matrix, DVec3::ZERO, Space::Patient).unwrap();
            let turn = placement.world_from_box();
            prop_assert!((turn * turn.transpose()).abs_diff_eq(DMat3::IDENTITY, 1e-9));
            prop_assert_eq!(turn.determinant() < 0.0, placement.is_left_handed());
        }
    }
}
