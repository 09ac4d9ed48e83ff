//! Arrays that NumPy, h5py, netCDF4, xarray and SciPy wrote: `tests/reference/arrays.py` made them, and wrote down what
//! they hold.

use fovol_core::Volume;
use fovol_io::volume::{Overrides, read};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Contents of a file for one choice of the user.
#[derive(Deserialize)]
struct Reference {
    array: Option<String>,
    time: Option<usize>,
    channel: Option<usize>,
    component: Option<usize>,
    dims: [usize; 3],
    spacing: [f64; 3],
    tolerance: f64,
    /// One in five values; missing ones are NaN.
    values: Vec<Option<f64>>,
}

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/array_files")
}

fn values(volume: &Volume) -> Vec<f64> {
    let [nx, ny, nz] = volume.grid().dims();
    let voxels = (0..nz).flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z])));
    voxels.map(|voxel| volume.value(voxel)).step_by(5).collect()
}

/// Whether `found` is `expected` within `tolerance` of the largest value.
fn are_near(found: &[f64], expected: &[Option<f64>], tolerance: f64) -> bool {
    let largest = expected.iter().flatten().fold(1.0f64, |largest, value| largest.max(value.abs()));
    let is_near = |(found, expected): (&f64, &Option<f64>)| match expected {
        Some(expected) => (found - expected).abs() <= tolerance * largest,
        None => found.is_nan(),
    };
    found.len() == expected.len() && found.iter().zip(expected).all(is_near)
}

#[test]
fn every_file_is_what_other_programs_wrote() {
    let text = std::fs::read(folder().join("values.json")).unwrap();
    let files: BTreeMap<String, Vec<Reference>> = serde_json::from_slice(&text).unwrap();
    assert!(files.len() > 30);
    for (name, references) in files {
        if !cfg!(feature = "hdf5") && !name.contains(".np") {
            continue;
        }
        for Reference { array, time, channel, component, dims, spacing, tolerance, values: expected } in
            references
        {
            let overrides = Overrides { array, time, channel, component, ..Overrides::default() };
            let volume = read(&folder().join(&name), &overrides).unwrap();
            assert_eq!(volume.grid().dims(), dims, "{name}");
            let is_spaced =
                volume.grid().spacing().iter().zip(spacing).all(|(a, b)| (a - b).abs() <= 1e-6 * b);
            assert!(is_spaced, "{name}: {:?}, not {spacing:?}", volume.grid().spacing());
            assert!(are_near(&values(&volume), &expected, tolerance), "{name}: {:?}", values(&volume));
        }
    }
}

#[test]
#[cfg(not(feature = "hdf5"))]
fn builds_without_hdf5_name_the_feature() {
    for name in ["a.h5", "b.nc", "c.ims"] {
        let source = fovol_io::volume::Source::from_bytes(Path::new(name), b"\x89HDF\r\n\x1a\n".to_vec());
        let error = fovol_io::volume::parse(&source, &Overrides::default()).unwrap_err().to_string();
        assert!(error.contains("feature `hdf5`"), "{error}");
    }
}
