//! Facts about a volume that its NumPy array does not hold.

use crate::errors::wrong;
use fovolnet::core::{Contents, Placement, Rescale, Result, Space, Volume};
use glam::{DMat3, DVec3};
use pyo3::PyResult;
use serde::Deserialize;

/// Facts about the voxels of an array, as a JSON object.
#[derive(Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ArrayFacts {
    /// Distance of voxels along x, y, z.
    pub spacing: [f64; 3],
    /// Name in notes.
    pub source: String,
    /// Whether voxels with three or four components have colours.
    pub rgb: bool,
    /// Values shown as 0 and 1.
    range: Option<[f64; 2]>,
    /// Slope and intercept: a value is slope · stored + intercept.
    rescale: Option<[f64; 2]>,
    /// Directions of the axes x, y, z, one after the other.
    directions: Option<[[f64; 3]; 3]>,
    /// Centre of the first voxel.
    origin: [f64; 3],
    /// Whether directions and origin are in patient space: left, posterior, superior.
    patient: bool,
    /// Whether the values are labels.
    labels: bool,
    /// Unit of the spacing.
    units: Option<String>,
}

impl Default for ArrayFacts {
    fn default() -> Self {
        Self {
            spacing: [1.0; 3],
            source: "the array".into(),
            rgb: false,
            range: None,
            rescale: None,
            directions: None,
            origin: [0.0; 3],
            patient: false,
            labels: false,
            units: None,
        }
    }
}

impl ArrayFacts {
    /// The facts of `json`.
    pub fn parse(json: &str) -> PyResult<Self> {
        serde_json::from_str(json).map_err(|error| wrong(error.to_string()))
    }

    /// `volume` with these facts.
    pub fn told_to(&self, mut volume: Volume) -> Result<Volume> {
        if let Some([slope, intercept]) = self.rescale {
            volume = volume.with_rescale(Rescale { slope, intercept })?;
        }
        if let Some(range) = self.range {
            volume = volume.with_range(range)?;
        }
        if let Some(directions) = self.directions {
            let directions = DMat3::from_cols_array_2d(&directions);
            let space = if self.patient { Space::Patient } else { Space::Other };
            volume = volume.with_placement(Placement::new(directions, DVec3::from(self.origin), space)?);
        }
        if let Some(units) = &self.units {
            volume = volume.with_units(units.clone());
        }
        if self.labels {
            let contents = Contents { are_labels: true, ..volume.contents().clone() };
            volume = volume.with_contents(contents);
        }
        Ok(volume)
    }
}
