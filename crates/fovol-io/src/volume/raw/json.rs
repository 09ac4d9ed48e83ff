//! `.json` sidecars: what this program writes, and the catalogue entries of the Open SciVis data sets.

use super::description::Description;
use crate::Result;
use crate::volume::Source;
use fovol_core::{Dtype, Endian, Volume};
use serde::{Deserialize, Serialize};

/// A sidecar has a few fields; nobody should wait for a gigabyte of JSON.
const LONGEST: usize = 1 << 20;

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
    Ok(Description {
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
    let sidecar = Sidecar {
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
