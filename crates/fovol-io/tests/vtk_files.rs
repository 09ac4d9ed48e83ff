//! Rectilinear grids and images in pieces that VTK wrote: `tests/reference/vtk_files.py` made them, and wrote down what
//! they hold.

use fovol_io::volume::{Overrides, Source, parse, read};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// One array of a file.
#[derive(Deserialize)]
struct Reference {
    array: String,
    dims: [usize; 3],
    spacing: [f64; 3],
    origin: [f64; 3],
    /// One in three values.
    values: Vec<f64>,
}

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/vtk_files")
}

fn are_near(found: &[f64], expected: &[f64]) -> bool {
    let is_near = |(a, b): (&f64, &f64)| (a - b).abs() <= 1e-4;
    found.len() == expected.len() && found.iter().zip(expected).all(is_near)
}

#[test]
fn every_file_is_what_vtk_wrote() {
    let text = std::fs::read(folder().join("values.json")).unwrap();
    let files: BTreeMap<String, Vec<Reference>> = serde_json::from_slice(&text).unwrap();
    for (name, references) in files {
        for Reference { array, dims, spacing, origin, values } in references {
            let overrides = Overrides { array: Some(array), ..Overrides::default() };
            let volume = read(&folder().join(&name), &overrides).unwrap();
            assert_eq!(volume.grid().dims(), dims, "{name}");
            assert!(are_near(&volume.grid().spacing(), &spacing), "{name}");
            assert!(are_near(&volume.placement().unwrap().origin().to_array(), &origin), "{name}");
            let [nx, ny, nz] = dims;
            let voxels =
                (0..nx * ny * nz).step_by(3).map(|i| volume.value([i % nx, i / nx % ny, i / nx / ny]));
            let found: Vec<f64> = voxels.collect();
            assert!(are_near(&found, &values), "{name}: {found:?}, not {values:?}");
            let is_resampled = volume.notes().iter().any(|note| note.contains("resampled"));
            assert_eq!(is_resampled, name.contains("uneven") || name.contains("mixed"), "{name}");
        }
    }
}

#[test]
fn missing_pieces_and_other_data_say_what_to_do() {
    let copy = tempfile::tempdir().unwrap();
    let path = copy.path().join("pieces.pvti");
    std::fs::copy(folder().join("pieces.pvti"), &path).unwrap();
    let error = read(&path, &Overrides::default()).unwrap_err().to_string();
    assert!(error.contains("is missing; put it beside this file"), "{error}");

    let text = std::fs::read_to_string(&path).unwrap();
    let pieces: Vec<&str> = text.lines().filter(|line| !line.contains("pieces_1.vti")).collect();
    for number in [0, 2] {
        let name = format!("pieces_{number}.vti");
        std::fs::copy(folder().join(&name), copy.path().join(&name)).unwrap();
    }
    std::fs::write(&path, pieces.join("\n")).unwrap();
    let error = read(&path, &Overrides::default()).unwrap_err().to_string();
    assert!(error.contains("leave"), "{error}");

    for (name, text) in [
        ("x.vtu", "<VTKFile type=\"UnstructuredGrid\"><UnstructuredGrid/></VTKFile>"),
        ("x.vtk", "# vtk DataFile Version 3.0\ntitle\nASCII\nDATASET UNSTRUCTURED_GRID\n"),
        ("x.vtu", "no XML"),
    ] {
        let source = Source::from_bytes(Path::new(name), text.into());
        let error = parse(&source, &Overrides::default()).unwrap_err().to_string();
        assert!(error.contains("Resample To Image") && error.contains(".vti"), "{error}");
    }
}
