//! Spacing of voxels from the coordinates of axes.

use crate::volume::units::{metres, symbol};

/// Coordinates of one axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Coordinate {
    /// Name of the axis.
    pub name: String,
    /// Position of each voxel.
    pub values: Vec<f64>,
    /// Unit of the positions, as the file calls it.
    pub units: Option<String>,
}

/// Spacing of a grid, and remarks about it.
#[derive(Debug, Clone, PartialEq)]
pub struct Spaced {
    /// The distance between voxels along x, y, z.
    pub spacing: [f64; 3],
    /// The unit of all three, if it is a length.
    pub units: Option<String>,
    /// Remarks on assumptions, one line each.
    pub notes: Vec<String>,
}

/// Steps that differ by more than this part are irregular.
const REGULAR: f64 = 1e-3;

/// Spacing along one axis.
struct Step {
    length: f64,
    units: String,
}

impl Spaced {
    /// Spacing from the coordinates of x, y, z, as far as they are known; none if none is.
    ///
    /// An axis whose unit cannot be compared with that of the others takes the spacing of the first that has one.
    pub fn from_coordinates(coordinates: &[Option<Coordinate>; 3]) -> Option<Self> {
        let mut notes = Vec::new();
        let steps = coordinates.each_ref().map(|axis| axis.as_ref().and_then(|axis| axis.step(&mut notes)));
        let base = steps.iter().flatten().next()?;
        let mut spacing = [base.length; 3];
        for (axis, step) in steps.iter().enumerate() {
            let Some(step) = step else { continue };
            match ratio(&step.units, &base.units) {
                Some(ratio) => spacing[axis] = step.length * ratio,
                None => notes.push(format!(
                    "its {} is in {}, but other axes are in {}; its spacing is taken as theirs, --spacing X,Y,Z sets another",
                    ["x", "y", "z"][axis],
                    called(&step.units),
                    called(&base.units)
                )),
            }
        }
        Some(Self { spacing, units: metres(&base.units).is_some().then(|| base.units.clone()), notes })
    }
}

impl Coordinate {
    /// The mean step; none if there is no step or no number.
    fn step(&self, notes: &mut Vec<String>) -> Option<Step> {
        let [first, .., last] = *self.values.as_slice() else { return None };
        let mean = (last - first) / (self.values.len() - 1) as f64;
        if !mean.is_finite() || mean == 0.0 {
            return None;
        }
        let name = &self.name;
        let is_regular = |pair: &[f64]| (pair[1] - pair[0] - mean).abs() <= REGULAR * mean.abs();
        if !self.values.windows(2).all(is_regular) {
            notes.push(format!(
                "its coordinates `{name}` are not regular; their mean step {} is taken",
                mean.abs()
            ));
        }
        if mean < 0.0 {
            notes.push(format!(
                "its coordinates `{name}` descend; the voxels are shown in the order of the file"
            ));
        }
        let units = symbol(self.units.as_deref().unwrap_or_default()).to_owned();
        Some(Step { length: mean.abs(), units })
    }
}

/// How many `to` make one `from`, if they can be compared.
fn ratio(from: &str, to: &str) -> Option<f64> {
    if kind(from) == kind(to) {
        return Some(1.0);
    }
    Some(metres(from)? / metres(to)?)
}

/// `unit` without the direction that degrees have.
fn kind(unit: &str) -> &str {
    if unit.starts_with("degree") { "degrees" } else { unit }
}

fn called(unit: &str) -> &str {
    if unit.is_empty() { "no unit" } else { unit }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axis(values: &[f64], units: &str) -> Option<Coordinate> {
        Some(Coordinate { name: "c".into(), values: values.to_vec(), units: Some(units.into()) })
    }

    #[test]
    fn lengths_are_converted() {
        let axes = [axis(&[0.0, 2.0, 4.0], "mm"), axis(&[1.0, 1.5], "cm"), axis(&[3.0, 2.0], "micrometer")];
        let spaced = Spaced::from_coordinates(&axes).unwrap();
        assert_eq!(spaced.units.as_deref(), Some("mm"));
        for (found, expected) in spaced.spacing.into_iter().zip([2.0, 5.0, 0.001]) {
            assert!((found - expected).abs() < 1e-12, "{found}");
        }
        assert!(spaced.notes.len() == 1 && spaced.notes[0].contains("descend"), "{:?}", spaced.notes);
    }

    #[test]
    fn units_that_cannot_be_compared_are_noted() {
        let axes =
            [axis(&[0.0, 2.0], "degrees_east"), axis(&[9.0, 8.0], "degrees_north"), axis(&[1e5, 9e4], "Pa")];
        let spaced = Spaced::from_coordinates(&axes).unwrap();
        assert_eq!((spaced.spacing, spaced.units), ([2.0, 1.0, 2.0], None));
        assert!(spaced.notes.iter().any(|note| note.contains("its z is in Pa")), "{:?}", spaced.notes);
    }

    #[test]
    fn irregular_steps_are_noted() {
        let axes = [axis(&[0.0, 1.0, 4.0], "m"), None, axis(&[7.0], "m")];
        let spaced = Spaced::from_coordinates(&axes).unwrap();
        assert_eq!(spaced.spacing, [2.0; 3]);
        assert!(spaced.notes[0].contains("not regular"));
        assert_eq!(Spaced::from_coordinates(&[None, axis(&[f64::NAN; 3], "m"), None]), None);
    }
}
