//! How the picture of a slice lies in the grid.

use eframe::egui::Color32;
use fovolnet::core::Placement;

/// One of three orthogonal slices.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Plane {
    /// Across the axis of the body; across z in a grid.
    Axial,
    /// Parallel to the face; across y in a grid.
    Coronal,
    /// Divides left from right; across x in a grid.
    Sagittal,
}

impl Plane {
    /// All planes, in the order of their pictures.
    pub const ALL: [Self; 3] = [Self::Axial, Self::Coronal, Self::Sagittal];

    /// Colour of the slice's name and of its lines in the other slices.
    pub fn colour(self) -> Color32 {
        match self {
            Self::Axial => Color32::from_rgb(240, 100, 90),
            Self::Coronal => Color32::from_rgb(110, 205, 95),
            Self::Sagittal => Color32::from_rgb(235, 205, 80),
        }
    }
}

/// Direction along an axis of the grid.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Way {
    /// Axis of the grid.
    pub axis: usize,
    /// Whether voxel numbers rise in this direction.
    pub rises: bool,
}

/// How the picture of a slice lies in the grid.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Lie {
    /// The plane.
    pub plane: Plane,
    /// Name of the plane.
    pub name: &'static str,
    /// To the right in the picture.
    pub right: Way,
    /// Downwards in the picture.
    pub down: Way,
    /// From slice to slice: towards head, face or left hand.
    pub across: Way,
    /// Letters at the left, top, right and bottom edge.
    pub edges: [&'static str; 4],
}

impl Lie {
    /// Picture of `plane` as radiologists see the patient, who lies in the grid as `placement` says. Oblique grids are
    /// cut along the axes nearest to the patient's. Without a placement, axes of the grid rise to the right and
    /// upwards.
    pub fn new(plane: Plane, placement: Option<&Placement>) -> Self {
        match placement {
            Some(placement) => Self::of_patient(plane, &placement.letters()),
            None => Self::of_grid(plane),
        }
    }

    fn of_patient(plane: Plane, letters: &str) -> Self {
        let [name, right, down, across] = match plane {
            Plane::Axial => ["Axial", "L", "P", "S"],
            Plane::Coronal => ["Coronal", "L", "I", "A"],
            Plane::Sagittal => ["Sagittal", "P", "I", "L"],
        };
        let towards = |side| {
            let axis = |side: &str| letters.find(side);
            let rising = axis(side).map(|axis| Way { axis, rises: true });
            let falling = axis(opposite(side)).map(|axis| Way { axis, rises: false });
            rising.or(falling).expect("an axis of the grid is nearest to each of the patient's")
        };
        Self {
            plane,
            name,
            right: towards(right),
            down: towards(down),
            across: towards(across),
            edges: [opposite(right), opposite(down), right, down],
        }
    }

    fn of_grid(plane: Plane) -> Self {
        let (name, [right, up, across], edges) = match plane {
            Plane::Axial => ("z", [0, 1, 2], ["−x", "y", "x", "−y"]),
            Plane::Coronal => ("y", [0, 2, 1], ["−x", "z", "x", "−z"]),
            Plane::Sagittal => ("x", [1, 2, 0], ["−y", "z", "y", "−z"]),
        };
        let way = |axis, rises| Way { axis, rises };
        Self { plane, name, right: way(right, true), down: way(up, false), across: way(across, true), edges }
    }
}

/// The other side of the patient.
fn opposite(side: &str) -> &'static str {
    match side {
        "L" => "R",
        "R" => "L",
        "P" => "A",
        "A" => "P",
        "S" => "I",
        _ => "S",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovolnet::core::Space;
    use glam::{DMat3, DVec3};

    fn placed(x: DVec3, y: DVec3, z: DVec3) -> Placement {
        Placement::new(DMat3::from_cols(x, y, z), DVec3::ZERO, Space::Patient).unwrap()
    }

    fn way(axis: usize, rises: bool) -> Way {
        Way { axis, rises }
    }

    #[test]
    fn left_is_on_the_right_and_heads_are_up() {
        let ras = placed(DVec3::NEG_X, DVec3::NEG_Y, DVec3::Z);
        let axial = Lie::new(Plane::Axial, Some(&ras));
        assert_eq!((axial.right, axial.down, axial.across), (way(0, false), way(1, false), way(2, true)));
        assert_eq!(axial.edges, ["R", "A", "L", "P"]);
        let coronal = Lie::new(Plane::Coronal, Some(&ras));
        assert_eq!(
            (coronal.right, coronal.down, coronal.across),
            (way(0, false), way(2, false), way(1, true))
        );
        assert_eq!(coronal.edges, ["R", "S", "L", "I"]);
        let sagittal = Lie::new(Plane::Sagittal, Some(&ras));
        assert_eq!((sagittal.right, sagittal.down), (way(1, false), way(2, false)));
        assert_eq!((sagittal.across, sagittal.edges), (way(0, false), ["A", "S", "P", "I"]));
    }

    #[test]
    fn axes_in_any_order_are_found() {
        // As a sagittal acquisition is stored: x to the back, y down, z to the left; turned a little.
        let tilted =
            placed(DVec3::new(0.1, 1.0, 0.2), DVec3::new(0.05, 0.2, -1.0), DVec3::new(1.0, -0.1, 0.05));
        let axial = Lie::new(Plane::Axial, Some(&tilted));
        assert_eq!((axial.right, axial.down, axial.across), (way(2, true), way(0, true), way(1, false)));
        let sagittal = Lie::new(Plane::Sagittal, Some(&tilted));
        assert_eq!(
            (sagittal.right, sagittal.down, sagittal.across),
            (way(0, true), way(1, true), way(2, true))
        );
    }

    #[test]
    fn grids_rise_right_and_up() {
        for (plane, right, up, across) in
            [(Plane::Axial, 0, 1, 2), (Plane::Coronal, 0, 2, 1), (Plane::Sagittal, 1, 2, 0)]
        {
            let lie = Lie::new(plane, None);
            assert_eq!(
                (lie.right, lie.down, lie.across),
                (way(right, true), way(up, false), way(across, true))
            );
        }
    }
}
