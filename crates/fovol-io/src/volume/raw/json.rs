//! `.json` sidecars: what this program writes, and the catalogue entries of the Open SciVis data sets.

use super::description::Description;
use crate::Result;
use crate::volume::Source;
use fovol_core::{Dtype, Endian, Placement, Space, Volume};
use glam::{DMat3, DVec3};
use serde::{Deserialize, Serialize};

/// A sidecar has a few fields; nobody should wait for a gigabyte of JSON.
pub const LONGEST: usize = 1 << 20;

#[derive(Serialize, Deserialize)]
struct Sidecar {
    #[serde(default, skip_serializing_if = "Option::is_none")]
    file: Option<String>,
    #[serde(alias = "size", alias = "resolution")]
    dims: [usize; 3],
    #[serde(alias = "type")]
    dtype: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    endian: Option<Endian>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    components: Option<usize>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    spacing: Option<[f64; 3]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    offset: Option<usize>,
    /// The rows of the matrix whose columns are the voxel axes, in LPS.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    orientation: Option<[[f64; 3]; 3]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    origin: Option<[f64; 3]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    space: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    units: Option<String>,
}

/// The name of the patient's space; axes of any other are not those of a patient.
const PATIENT: &str = "patient";

impl Sidecar {
    fn placement(&self, source: &Source) -> Result<Option<Placement>> {
        let Some(rows) = self.orientation else { return Ok(None) };
        let space = if self.space.as_deref() == Some(PATIENT) { Space::Patient } else { Space::Other };
        let axes = DMat3::from_cols_array_2d(&rows).transpose();
        let origin = DVec3::from_array(self.origin.unwrap_or_default());
        Placement::new(axes, origin, space).map(Some).map_err(|e| source.malformed(e.to_string()))
    }
}

/// Reads the sidecar `source`.
///
/// # Errors
/// Something else than the JSON of a sidecar.
pub fn parse(source: &Source) -> Result<Description> {
    let bytes = source.bytes();
    if bytes.len() > LONGEST {
        return Err(source.malformed("it is too long for the description of a raw volume"));
    }
    let said: Sidecar = serde_json::from_slice(bytes).map_err(|e| {
        source.malformed(format!(
            "it is no description of a raw volume ({e}); it needs dims [x, y, z] and dtype"
        ))
    })?;
    let dtype = said.dtype.parse::<Dtype>().map_err(|problem| source.malformed(problem))?;
    let placement = said.placement(source)?;
    Ok(Description {
        placement,
        units: said.units,
        file: said.file,
        dims: Some(said.dims),
        dtype: Some(dtype),
        endian: said.endian,
        components: said.components,
        spacing: said.spacing,
        offset: said.offset,
        dims_are_chosen: false,
    })
}

/// The sidecar of `volume`, whose first component lies little-endian in `file` as `dtype`.
pub fn text(volume: &Volume, dtype: Dtype, file: &str) -> String {
    let placement = volume.placement();
    let sidecar = Sidecar {
        orientation: placement.map(|placement| placement.directions().transpose().to_cols_array_2d()),
        origin: placement.map(|placement| placement.origin().to_array()),
        space: placement.map(|placement| match placement.space() {
            Space::Patient => PATIENT.into(),
            Space::Other => "other".into(),
        }),
        units: volume.units().map(str::to_owned),
        file: Some(file.to_owned()),
        dims: volume.grid().dims(),
        dtype: dtype.to_string(),
        endian: Some(Endian::Little),
        components: None,
        spacing: Some(volume.grid().spacing()),
        offset: None,
    };
    let text = serde_json::to_string_pretty(&sidecar).expect("numbers and names have a JSON form");
    text + "\n"
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn said(text: &str) -> Result<Description> {
        parse(&Source::from_bytes(Path::new("x.json"), text.as_bytes().to_vec()))
    }

    #[test]
    fn catalogue_entries_are_read() {
        let said =
            said(r#"{"name": "Fuel", "type": "uint8", "size": [64, 64, 64], "spacing": [1, 1, 2]}"#).unwrap();
        assert_eq!((said.dims, said.dtype), (Some([64; 3]), Some(Dtype::U8)));
        assert_eq!(said.spacing, Some([1.0, 1.0, 2.0]));
    }

    #[test]
    fn other_json_is_a_one_line_error() {
        for text in
            ["", "[1]", "{}", r#"{"dims": [1, 2], "dtype": "u8"}"#, r#"{"dims": [1, 2, -3], "dtype": "u8"}"#]
        {
            let error = said(text).unwrap_err().to_string();
            assert!(!error.contains('\n'), "{error}");
        }
        assert!(said(r#"{"dims": [1, 2, 3], "dtype": "u9"}"#).is_err());
    }
}
