//! Conventions by which NetCDF and HDF5 files describe their arrays: names and coordinates of axes, packed values.
//!
//! Source: <https://cfconventions.org/Data/cf-conventions/cf-conventions-1.11/cf-conventions.html>.

mod coordinates;
mod packing;
mod stated;

use super::array_axes::ArrayAxes;
pub use coordinates::{Coordinate, Spaced};
pub use packing::unpacked;
pub use stated::{stated_spacing, with_spacing_notes};
use std::collections::{BTreeMap, HashSet};

/// The value of an attribute.
#[derive(Debug, Clone, PartialEq)]
pub enum Attribute {
    /// One number or several.
    Numbers(Vec<f64>),
    /// Text.
    Text(String),
}

/// Attributes of an array, by name.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Attributes(pub BTreeMap<String, Attribute>);

impl Attributes {
    /// All numbers of the attribute `name`; none where it is text or missing.
    pub fn numbers(&self, name: &str) -> &[f64] {
        match self.0.get(name) {
            Some(Attribute::Numbers(numbers)) => numbers,
            _ => &[],
        }
    }

    /// The first number of the attribute `name`.
    pub fn number(&self, name: &str) -> Option<f64> {
        self.numbers(name).first().copied()
    }

    /// The text of the attribute `name`.
    pub fn text(&self, name: &str) -> Option<&str> {
        match self.0.get(name) {
            Some(Attribute::Text(text)) => Some(text),
            _ => None,
        }
    }
}

/// Names that the attributes of arrays give to arrays that describe them: bounds and coordinates of cells.
pub fn auxiliary<'a>(all: impl Iterator<Item = &'a Attributes>) -> HashSet<String> {
    let names = all.flat_map(|found| ["bounds", "climatology", "coordinates"].map(|name| found.text(name)));
    names.flatten().flat_map(str::split_whitespace).map(str::to_owned).collect()
}

/// Description of an array by its file.
#[derive(Debug, Clone, Default)]
pub struct Described {
    /// Lengths of the axes.
    pub shape: Vec<usize>,
    /// Names of the axes, where the file has them.
    pub names: Vec<Option<String>>,
    /// Units of the coordinates of the first axis.
    pub first_units: Option<String>,
}

impl Described {
    /// The meaning of the axes. A first axis that the file calls time is time.
    ///
    /// # Errors
    /// Shapes that are no volume.
    pub fn axes(&self) -> Result<ArrayAxes, String> {
        match self.is_after_time() {
            true => ArrayAxes::after_time(&self.shape),
            false => ArrayAxes::of(&self.shape),
        }
    }

    fn is_after_time(&self) -> bool {
        let name = self.names.first().and_then(Option::as_deref).unwrap_or_default().to_ascii_lowercase();
        ["time", "times", "t"].contains(&name.as_str())
            || self.first_units.as_deref().is_some_and(|units| units.contains(" since "))
    }
}
