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
    let is_near = |(a, b): (&f64, &f64)| (a - b).abs() <= 1e-4 + 1e-5 * b.abs();
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
    for number in 0..3 {
        let name = format!("pieces_{number}.vti");
        std::fs::copy(folder().join(&name), copy.path().join(&name)).unwrap();
    }
    // VTK gave every piece the whole extent.
    assert!(read(&path, &Overrides::default()).is_ok());
    let whole = |last: u32| format!("WholeExtent=\"-2 6 1 7 0 {last}\"");
    assert!(text.contains(&whole(5)));
    std::fs::write(&path, text.replace(&whole(5), &whole(9))).unwrap();
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

/// Two pieces that share a plane of points, as parallel programs write them.
#[test]
fn pieces_stand_where_their_extents_say() {
    let folder = tempfile::tempdir().unwrap();
    let value = |[x, y, z]: [usize; 3]| 100 * z + 10 * y + x;
    let piece = |name: &str, [from, to]: [usize; 2]| {
        let points = (0..2).flat_map(|z| (0..3).flat_map(move |y| (from..=to).map(move |x| [x, y, z])));
        let values: Vec<String> = points.map(|point| value(point).to_string()).collect();
        let extent = format!("{from} {to} 0 2 0 1");
        let text = format!(
            "<VTKFile type=\"ImageData\" byte_order=\"LittleEndian\"><ImageData WholeExtent=\"{extent}\" Origin=\"0 0 0\" \
             Spacing=\"1 1 1\"><Piece Extent=\"{extent}\"><PointData Scalars=\"a\"><DataArray type=\"Int16\" Name=\"a\" \
             format=\"ascii\">{}</DataArray></PointData></Piece></ImageData></VTKFile>",
            values.join(" ")
        );
        std::fs::write(folder.path().join(name), text).unwrap();
        format!("<Piece Extent=\"{extent}\" Source=\"{name}\"/>")
    };
    let pieces = [piece("a.vti", [0, 2]), piece("b.vti", [2, 4])].concat();
    let text = format!(
        "<VTKFile type=\"PImageData\" byte_order=\"LittleEndian\"><PImageData WholeExtent=\"0 4 0 2 0 1\" Origin=\"0 0 0\" \
         Spacing=\"1 1 1\"><PPointData Scalars=\"a\"><PDataArray type=\"Int16\" Name=\"a\"/></PPointData>{pieces}</PImageData></VTKFile>"
    );
    let path = folder.path().join("all.pvti");
    std::fs::write(&path, text).unwrap();
    let volume = read(&path, &Overrides::default()).unwrap();
    assert_eq!(volume.grid().dims(), [5, 3, 2]);
    for at in (0..30).map(|i| [i % 5, i / 5 % 3, i / 15]) {
        assert_eq!(volume.value(at), value(at) as f64, "{at:?}");
    }
}
