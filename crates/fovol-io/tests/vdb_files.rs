//! Files that OpenVDB and NanoVDB wrote: `tests/reference/vdb_files.py` made them, and wrote down what they hold.

use fovol_core::Volume;
use fovol_io::volume::{Overrides, Source, parse, read};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::io::Read;
use std::path::{Path, PathBuf};

/// The content of a file for one choice of the user.
#[derive(Deserialize)]
struct Reference {
    kind: String,
    array: Option<String>,
    component: usize,
    dims: [usize; 3],
    spacing: [f64; 3],
    origin: [f64; 3],
    /// One in so many values is written down.
    step: usize,
    values: Vec<f64>,
}

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/vdb_files")
}

fn values(volume: &Volume, step: usize) -> Vec<f64> {
    let [nx, ny, nz] = volume.grid().dims();
    (0..nx * ny * nz).step_by(step).map(|i| volume.value([i % nx, i / nx % ny, i / nx / ny])).collect()
}

fn are_near(found: &[f64], expected: &[f64]) -> bool {
    let is_near = |(a, b): (&f64, &f64)| (a - b).abs() <= 1e-7 * b.abs().max(1.0);
    found.len() == expected.len() && found.iter().zip(expected).all(is_near)
}

#[test]
fn every_file_is_what_openvdb_wrote() {
    let text = std::fs::read(folder().join("values.json")).unwrap();
    let files: BTreeMap<String, Vec<Reference>> = serde_json::from_slice(&text).unwrap();
    assert!(files.len() > 40);
    for (name, references) in files {
        for Reference { kind, array, component, dims, spacing, origin, step, values: expected } in references
        {
            let overrides = Overrides { array, component: Some(component), ..Overrides::default() };
            let volume = read(&folder().join(&name), &overrides).unwrap();
            assert_eq!(volume.grid().dims(), dims, "{name} {kind}");
            assert!(are_near(&volume.grid().spacing(), &spacing), "{name} {kind}");
            let found = volume.placement().unwrap().origin().to_array();
            assert!(are_near(&found, &origin), "{name} {kind}: {found:?}, not {origin:?}");
            let found = values(&volume, step);
            assert!(are_near(&found, &expected), "{name} {kind}: {found:?}, not {expected:?}");
            let is_noted = volume.notes().iter().any(|note| note.contains("level set"));
            assert!(is_noted || !kind.contains("level set"), "{name} {kind}");
        }
    }
}

/// The unpacked content of the first sample with this ending.
fn sample(ending: &str) -> Vec<u8> {
    let names = std::fs::read_dir(folder()).unwrap().map(|entry| entry.unwrap().path());
    let path = names.filter(|path| path.to_string_lossy().ends_with(ending)).min().unwrap();
    let mut bytes = Vec::new();
    flate2::read::GzDecoder::new(std::fs::File::open(path).unwrap()).read_to_end(&mut bytes).unwrap();
    bytes
}

fn error(name: &str, bytes: Vec<u8>) -> String {
    let error =
        parse(&Source::from_bytes(Path::new(name), bytes), &Overrides::default()).unwrap_err().to_string();
    assert!(error.starts_with(name) && error.contains("; ") && !error.contains('\n'), "{error}");
    error
}

#[test]
fn older_versions_of_the_same_layout_are_read() {
    for version in [222, 223] {
        let mut bytes = sample(".vdb.gz");
        bytes[8] = version;
        parse(&Source::from_bytes(Path::new("x.vdb"), bytes), &Overrides::default()).unwrap();
    }
}

#[test]
fn what_cannot_be_read_is_said_in_one_line() {
    let mut old = sample(".vdb.gz");
    old[8] = 221;
    assert!(error("x.vdb", old).contains("version 221"));
    let mut new = sample(".nvdb.gz");
    new[11] = 0xFF;
    assert!(error("x.nvdb", new).contains("nanovdb_convert"));
    for ending in [".vdb.gz", ".nvdb.gz"] {
        let bytes = sample(ending);
        for part in 1..10 {
            error("x.vdb", bytes[..bytes.len() * part / 10].to_vec());
        }
    }
    error("x.vdb", b"nothing of the kind".to_vec());
    error("x.nvdb", b"nothing of the kind".to_vec());
}
