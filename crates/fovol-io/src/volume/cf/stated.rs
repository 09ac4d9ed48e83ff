//! Spacing that attributes of an array state, and notes where they state none.

use super::{Attributes, Spaced};
use crate::volume::Overrides;
use crate::volume::layout::placed;
use crate::volume::units::symbol;
use fovol_core::Volume;

/// Attributes of three numbers that are spacings by convention.
const NAMES: [&str; 6] = ["spacing", "voxel_size", "voxelsize", "voxel_spacing", "resolution", "pixel_size"];

/// Spacing by attributes of three numbers, z, y, x.
pub fn stated_spacing(found: &Attributes) -> Option<Spaced> {
    if let Some(spacing) = triple(found, "element_size_um") {
        return Some(Spaced { spacing, units: Some("µm".into()), notes: Vec::new() });
    }
    let (name, spacing) = NAMES.iter().find_map(|name| Some((name, triple(found, name)?)))?;
    let [x, y, z] = spacing;
    let units =
        ["units", "unit", "spacing_units", "resolution_unit"].iter().find_map(|name| found.text(name));
    let note = format!(
        "its attribute `{name}` is read as the spacing along z, y, x: {z}, {y}, {x}; --spacing X,Y,Z sets another"
    );
    Some(Spaced { spacing, units: units.map(|name| symbol(name).to_owned()), notes: vec![note] })
}

/// The attribute `name` as a spacing along x, y, z.
fn triple(found: &Attributes, name: &str) -> Option<[f64; 3]> {
    match *found.numbers(name) {
        [z, y, x] if [x, y, z].iter().all(|step| step.is_finite() && *step > 0.0) => Some([x, y, z]),
        _ => None,
    }
}

/// `volume` with the unit of its spacing, and notes on assumptions about it unless the user sets it.
pub fn with_spacing_notes(volume: Volume, spaced: Option<&Spaced>, overrides: &Overrides) -> Volume {
    let said = overrides.spacing.is_some();
    match spaced {
        Some(spaced) => {
            let volume = placed(volume, None, spaced.units.as_deref());
            let notes = spaced.notes.iter().filter(|_| !said);
            notes.fold(volume, |volume, note| volume.with_note(note.as_str()))
        }
        None if said => volume,
        None => volume.with_note("it states no spacing, 1 is taken; --spacing X,Y,Z sets another"),
    }
}
