//! `.dat` sidecars: `Key: value` lines of Inviwo (`RawFile`) and of the Open Volume Library (`ObjectFileName`).

use super::description::Description;
use crate::Result;
use crate::volume::Source;
use fovol_core::{Dtype, Endian};

/// Sidecars are short; other files that end in `.dat` need not be read further.
const LONGEST: usize = 1 << 16;

/// Whether `source` is such a text rather than voxels.
pub fn is_one(source: &Source) -> bool {
    text(source).is_some_and(|text| {
        let has =
            |key: &str| text.lines().any(|line| line.to_ascii_lowercase().trim_start().starts_with(key));
        has("resolution") && has("format")
    })
}

/// Reads the sidecar `source`.
///
/// # Errors
/// Values that are no numbers or types.
pub fn parse(source: &Source) -> Result<Description> {
    let text = text(source).ok_or_else(|| source.malformed("it is no text, as .dat sidecars are"))?;
    let mut said = Description::default();
    for line in text.lines() {
        let Some((key, value)) = line.split_once(':') else { continue };
        let value = value.trim();
        match key.trim().to_ascii_lowercase().as_str() {
            "rawfile" | "objectfilename" => said.file = Some(value.to_owned()),
            "resolution" => said.dims = Some(three(source, "Resolution", value)?),
            "slicethickness" | "spacing" => said.spacing = Some(three(source, "SliceThickness", value)?),
            "byteoffset" => said.offset = Some(number(source, "ByteOffset", value)?),
            "byteorder" | "endian" => said.endian = Some(byte_order(source, value)?),
            "objectmodel" => said.components = said.components.or(channels(value)),
            "format" => {
                let (components, dtype) = format(value).ok_or_else(|| {
                    source.malformed(format!("its Format `{}` is no voxel type", value.escape_debug()))
                })?;
                said.dtype = Some(dtype);
                said.components = components.or(said.components);
            }
            _ => {}
        }
    }
    Ok(said)
}

/// Reads a format like `UCHAR`, `USHORT_12`, `UINT16`, `Vec3FLOAT32`.
pub fn format(text: &str) -> Option<(Option<usize>, Dtype)> {
    let lower = text.trim().to_ascii_lowercase();
    let (components, name) = match lower.strip_prefix("vec") {
        Some(rest) => (Some(rest.get(..1)?.parse().ok()?), rest.get(1..)?),
        None => (None, lower.as_str()),
    };
    // Twelve bits lie in two bytes.
    let name = match name.strip_suffix("_12") {
        Some(name) => name,
        None if name == "uint12" => "uint16",
        None if name == "int12" => "int16",
        None => name,
    };
    Some((components, name.parse().ok()?))
}

fn channels(model: &str) -> Option<usize> {
    match model.trim().to_ascii_uppercase().as_str() {
        "I" => Some(1),
        "LA" => Some(2),
        "RGB" | "XYZ" => Some(3),
        "RGBA" => Some(4),
        _ => None,
    }
}

fn byte_order(source: &Source, text: &str) -> Result<Endian> {
    let name = text.to_ascii_lowercase();
    let name = name.strip_suffix("endian").unwrap_or(&name).trim();
    name.parse().map_err(|problem: String| source.malformed(format!("its ByteOrder: {problem}")))
}

fn three<T: std::str::FromStr>(source: &Source, what: &str, text: &str) -> Result<[T; 3]> {
    let values: Result<Vec<T>> = text.split_whitespace().map(|word| number(source, what, word)).collect();
    values?.try_into().map_err(|_| source.malformed(format!("its {what} is not three numbers")))
}

fn number<T: std::str::FromStr>(source: &Source, what: &str, text: &str) -> Result<T> {
    text.parse().map_err(|_| source.malformed(format!("its {what} `{}` is no number", text.escape_debug())))
}

fn text(source: &Source) -> Option<&str> {
    let bytes = source.bytes();
    std::str::from_utf8(&bytes[..bytes.len().min(LONGEST)]).ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn said(text: &str) -> Result<Description> {
        parse(&Source::from_bytes(Path::new("x.dat"), text.as_bytes().to_vec()))
    }

    #[test]
    fn both_dialects() {
        let inviwo =
            said("RawFile: a.raw\nResolution: 13 7 3\nFormat: Vec3UINT16\nByteOrder: BigEndian\n").unwrap();
        assert_eq!((inviwo.dims, inviwo.dtype), (Some([13, 7, 3]), Some(Dtype::U16)));
        assert_eq!((inviwo.components, inviwo.endian), (Some(3), Some(Endian::Big)));
        let other = said(
            "ObjectFileName:\tb.raw\r\nResolution:\t1 2 3\r\nSliceThickness:\t1 1 2.5\r\nFormat:\tUSHORT_12\r\nObjectModel:\tRGBA\r\n",
        )
        .unwrap();
        assert_eq!((other.file.as_deref(), other.spacing), (Some("b.raw"), Some([1.0, 1.0, 2.5])));
        assert_eq!((other.dtype, other.components), (Some(Dtype::U16), Some(4)));
    }

    #[test]
    fn wrong_values_are_errors() {
        for text in
            ["Resolution: 1 2", "Resolution: a b c", "Format: COLOR", "ByteOrder: up", "ByteOffset: -1"]
        {
            assert!(said(text).is_err(), "{text}");
        }
    }

    #[test]
    fn voxels_are_no_sidecar() {
        assert!(!is_one(&Source::from_bytes(Path::new("x.dat"), vec![0xFF; 100])));
        assert!(!is_one(&Source::from_bytes(Path::new("x.dat"), b"text".to_vec())));
    }
}
