//! Placement of NRRD arrays: `space`, `space directions`, `space origin`, `space units`.

use super::axes::{Axes, vector};
use super::header::Header;
use crate::Result;
use crate::volume::Source;
use crate::volume::affine::Affine;
use crate::volume::units::symbol;
use fovol_core::{Placement, Space};
use glam::DVec3;

/// The placement of the array, if its header gives three-dimensional directions.
///
/// # Errors
/// Directions that span no space.
pub fn placement(source: &Source, header: &Header, axes: &Axes) -> Result<Option<Placement>> {
    let Some(steps) = steps(axes) else { return Ok(None) };
    let origin = header.get("spaceorigin").and_then(vector).unwrap_or(DVec3::ZERO);
    let (space, signs) = known(header.get("space").unwrap_or_default());
    let affine = Affine { steps, origin }.flipped(signs).spanning();
    affine.placement(source, space).map(Some)
}

/// The unit of the spacing, by its symbol: the one that all axes have.
pub fn units(header: &Header) -> Option<String> {
    let text = header.get("spaceunits").or_else(|| header.get("units"))?;
    let mut units = text.split('"').map(str::trim).filter(|word| !word.is_empty());
    let first = units.next()?;
    units.all(|unit| unit == first).then(|| symbol(first).to_owned())
}

/// The ways to the next voxel along x, y and z; an axis that the array lacks has none.
fn steps(axes: &Axes) -> Option<[DVec3; 3]> {
    let step = |axis: usize| axes.directions.get(axis).copied().flatten();
    let (x, y) = (step(0)?, step(1)?);
    Some([x, y, step(2).unwrap_or(DVec3::ZERO)])
}

/// The kind of the space called `name`, and the signs that convert its coordinates to LPS.
fn known(name: &str) -> (Space, DVec3) {
    let name = name.to_ascii_lowercase();
    let spatial = name.strip_suffix("-time").or_else(|| name.strip_suffix('t')).unwrap_or(&name);
    match spatial {
        "left-posterior-superior" | "lps" => (Space::Patient, DVec3::ONE),
        "right-anterior-superior" | "ras" => (Space::Patient, DVec3::new(-1.0, -1.0, 1.0)),
        "left-anterior-superior" | "las" => (Space::Patient, DVec3::new(1.0, -1.0, 1.0)),
        _ => (Space::Other, DVec3::ONE),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn of(text: &str) -> Result<Option<Placement>> {
        let source = Source::from_bytes(Path::new("x"), format!("NRRD0004\n{text}\n\n").into_bytes());
        let header = Header::parse(&source)?;
        placement(&source, &header, &Axes::of(&source, &header)?)
    }

    #[test]
    fn spaces_are_turned_to_lps() {
        let letters = |space: &str| {
            let text = format!(
                "sizes: 4 5 6\nspace: {space}\nspace directions: (3,0,0) (0,2,0) (0,0,1)\nspace origin: (1,2,3)"
            );
            let placed = of(&text).unwrap().unwrap();
            (placed.letters(), placed.space(), placed.origin())
        };
        assert_eq!(
            letters("left-posterior-superior"),
            ("LPS".into(), Space::Patient, DVec3::new(1.0, 2.0, 3.0))
        );
        assert_eq!(letters("RAS"), ("RAS".into(), Space::Patient, DVec3::new(-1.0, -2.0, 3.0)));
        assert_eq!(letters("left-anterior-superior-time").0, "LAS");
        assert_eq!(letters("scanner-xyz").1, Space::Other);
    }

    #[test]
    fn flat_arrays_and_arrays_without_directions() {
        assert_eq!(of("sizes: 4 5 6\nspacings: 1 2 3").unwrap(), None);
        let flat = of("sizes: 4 5\nspace: LPS\nspace directions: (1,0,0) (0,1,0)").unwrap().unwrap();
        assert_eq!(flat.letters(), "LPS");
        assert_eq!(of("sizes: 4 5\nspace dimension: 2\nspace directions: (1,0) (0,1)").unwrap(), None);
        let error = of("sizes: 4 5 6\nspace directions: (1,0,0) (1,0,0) (0,0,1)").unwrap_err().to_string();
        assert!(error.contains("span space") && !error.contains('\n'), "{error}");
    }

    #[test]
    fn units_that_all_axes_have() {
        let units = |text: &str| {
            let source = Source::from_bytes(Path::new("x"), format!("NRRD0004\n{text}\n\n").into_bytes());
            units(&Header::parse(&source).unwrap())
        };
        assert_eq!(units("space units: \"mm\" \"mm\" \"mm\""), Some("mm".into()));
        assert_eq!(units("space units: \"um\" \"um\" \"um\""), Some("µm".into()));
        assert_eq!(units("space units: \"mm\" \"mm\" \"s\""), None);
    }
}
