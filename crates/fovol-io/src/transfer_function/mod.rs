//! Transfer functions of this and other programs.

mod colour_space;
mod inviwo;
mod paraview;

use crate::{Error, Result, atomic};
use fovol_core::{ControlPoint, TransferFunction};
use std::io::Write;
use std::path::Path;

/// No transfer function needs more bytes than this; collections of colour maps included.
const LARGEST: u64 = 64 << 20;

/// Reads the transfer function at `path`: our JSON (`{"points":[[v,r,g,b,a],…]}`), ParaView JSON
/// (a list of colour maps; the first is taken, or the one called `NAME` where `path` ends in `#NAME`),
/// or Inviwo `.itf`.
///
/// # Errors
/// A file that is missing, damaged, or none of these.
pub fn read(path: &Path) -> Result<TransferFunction> {
    let (path, name) = with_name(path);
    let size = std::fs::metadata(&path).map_err(|e| Error::io("read", &path, e))?.len();
    if size > LARGEST {
        return Err(Error::malformed(
            &path,
            "it is too large for a transfer function; give a JSON or .itf file",
        ));
    }
    let text = std::fs::read_to_string(&path).map_err(|e| Error::io("read", &path, e))?;
    parse(&path, &text, name.as_deref())
}

/// Reads `text`, which came from `path`.
///
/// # Errors
/// As [`read`].
pub fn parse(path: &Path, text: &str, name: Option<&str>) -> Result<TransferFunction> {
    if text.trim_start().starts_with('<') {
        return inviwo::parse(path, text);
    }
    let json: serde_json::Value = serde_json::from_str(text).map_err(|e| {
        Error::malformed(
            path,
            format!(
                "it is neither JSON nor XML ({e}); give a transfer function as {{\"points\":[[v,r,g,b,a],…]}}"
            ),
        )
    })?;
    if json.get("points").is_some() {
        return serde_json::from_value(json).map_err(|e| Error::malformed(path, e.to_string()));
    }
    paraview::parse(path, &json, name)
}

/// Writes `transfer` as our JSON.
///
/// # Errors
/// What the system said.
pub fn write(path: &Path, transfer: &TransferFunction) -> Result<()> {
    let text = serde_json::to_string(transfer).map_err(|e| Error::malformed(path, e.to_string()))?;
    atomic::write(path, |out| writeln!(out, "{text}"))
}

/// Splits `file.json#NAME`, unless a file of that very name exists.
fn with_name(path: &Path) -> (std::path::PathBuf, Option<String>) {
    match path.to_str().and_then(|p| p.rsplit_once('#')) {
        Some((file, name)) if !path.exists() => (file.into(), Some(name.to_owned())),
        _ => (path.to_owned(), None),
    }
}

/// The transfer function of `points` in any order, numbers brought into [0, 1].
fn sorted(path: &Path, mut points: Vec<ControlPoint>) -> Result<TransferFunction> {
    for p in &mut points {
        p.value = p.value.clamp(0.0, 1.0);
        p.colour = p.colour.map(|c| c.clamp(0.0, 1.0));
        p.opacity = p.opacity.clamp(0.0, 1.0);
    }
    points.sort_by(|a, b| a.value.total_cmp(&b.value));
    TransferFunction::new(points).map_err(|e| Error::malformed(path, e.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(text: &str, name: Option<&str>) -> Result<TransferFunction> {
        parse(Path::new("tf"), text, name)
    }

    #[test]
    fn our_own_files_read_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("tf.json");
        let tf = TransferFunction::grey_ramp(0.25);
        write(&path, &tf).unwrap();
        assert_eq!(read(&path).unwrap(), tf);
    }

    #[test]
    fn paraview_maps_are_scaled_to_their_range_and_found_by_name() {
        let text = r#"[{"Name":"a","ColorSpace":"RGB","RGBPoints":[-1,0,0,0, 3,1,0.5,0]},
                       {"Name":"b","RGBPoints":[0,0,0,1, 1,1,0,0],"Points":[0,0,0.5,0, 1,0.5,0.5,0]}]"#;
        let a = parsed(text, None).unwrap();
        assert_eq!(&a.evaluate(0.5)[..3], [0.5, 0.25, 0.0]);
        let b = parsed(text, Some("b")).unwrap();
        assert_eq!(b.evaluate(0.5)[3], 0.25);
        assert!(parsed(text, Some("c")).unwrap_err().to_string().contains("a, b"));
    }

    #[test]
    fn inviwo_points_are_read() {
        let text = r#"<?xml version="1.0" ?><InviwoWorkspace version="2"><Points>
            <Point><pos content="0.25" /><rgba x="0.1" y="0.2" z="0.3" w="0" /></Point>
            <Point><pos content="0.75" /><rgba x="0.5" y="0.6" z="0.7" w="0.8" /></Point></Points></InviwoWorkspace>"#;
        let tf = parsed(text, None).unwrap();
        assert_eq!(tf.points().len(), 2);
        assert!((tf.evaluate(0.5)[3] - 0.4).abs() < 1e-12);
    }

    #[test]
    fn bad_files_are_errors() {
        for text in [
            "",
            "{",
            "[]",
            "{}",
            "[1,2]",
            r#"{"points":[]}"#,
            r#"{"points":[[0,0,0]]}"#,
            "<a>",
            "<InviwoWorkspace/>",
            r#"[{"Name":"x","RGBPoints":[0,0,0]}]"#,
            r#"[{"Name":"x","RGBPoints":["a",0,0,0]}]"#,
        ] {
            assert!(parsed(text, None).is_err(), "{text}");
        }
    }

    #[test]
    fn real_files_of_other_programs_are_read() {
        let Some(data) = crate::test_data() else { return };
        let maps = data.join("colormaps");
        let viridis = read(&maps.join("inviwo/matplotlib/viridis.itf")).unwrap();
        assert!((viridis.evaluate(1.0)[0] - 0.993).abs() < 0.01);
        let cool = read(&maps.join("vtkjs_ColorMaps.json#Cool to Warm")).unwrap();
        let middle = cool.evaluate(0.5);
        assert!(middle[..3].iter().all(|c| (0.8..0.9).contains(c)), "{middle:?}");
        // Cut off in the middle.
        assert!(read(&maps.join("paraview_ColorMaps.json")).is_err());
    }
}
