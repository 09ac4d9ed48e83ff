//! DICOM files made by pydicom and highdicom: every voxel, the place and the notes.
//!
//! `tests/reference/dicom.py references` makes the files and `dicom.json`.

#![cfg(feature = "dicom")]

use fovol_core::Volume;
use fovol_io::volume::{Overrides, read};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// What a file or folder holds, and how it is asked for.
#[derive(Deserialize)]
struct Entry {
    path: String,
    order: Order,
    dims: [usize; 3],
    spacing: [f64; 3],
    orientation: Option<[[f64; 3]; 3]>,
    origin: Option<[f64; 3]>,
    tolerance: f64,
    sum: f64,
    weighted: f64,
    note: Option<String>,
    labels: Option<Vec<(String, [u8; 3])>>,
}

#[derive(Deserialize)]
struct Order {
    series: Option<String>,
    time: Option<usize>,
    component: Option<usize>,
}

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/dicom_files")
}

fn entries() -> BTreeMap<String, Entry> {
    let text = std::fs::read_to_string(folder().join("dicom.json")).unwrap();
    serde_json::from_str(&text).unwrap()
}

fn volume(entry: &Entry) -> Volume {
    let Order { series, time, component } = &entry.order;
    let overrides =
        Overrides { series: series.clone(), time: *time, component: *component, ..Overrides::default() };
    read(&folder().join(&entry.path), &overrides).unwrap()
}

fn values(volume: &Volume) -> Vec<f64> {
    let [nx, ny, nz] = volume.grid().dims();
    (0..nx * ny * nz).map(|i| volume.value([i % nx, i / nx % ny, i / nx / ny])).collect()
}

fn is_near(a: &[f64], b: &[f64]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6)
}

#[test]
fn sizes_places_and_notes() {
    for (name, entry) in entries() {
        let volume = volume(&entry);
        assert_eq!(volume.grid().dims(), entry.dims, "{name}");
        assert!(is_near(&volume.grid().spacing(), &entry.spacing), "{name}: {:?}", volume.grid());
        let placement = volume.placement();
        let directions = placement.map(|placement| placement.directions().transpose().to_cols_array());
        let expected = entry.orientation.map(|rows| rows.as_flattened().to_vec());
        assert_eq!(directions.is_some(), expected.is_some(), "{name}");
        if let (Some(directions), Some(expected)) = (directions, expected) {
            assert!(is_near(&directions, &expected), "{name}: {directions:?}, not {expected:?}");
        }
        if let (Some(placement), Some(origin)) = (placement, entry.origin) {
            assert!(is_near(&placement.origin().to_array(), &origin), "{name}: {}", placement.origin());
        }
        let notes = volume.notes().join("|");
        assert!(entry.note.is_none_or(|note| notes.contains(&note)), "{name}: {notes}");
        assert!(!notes.to_lowercase().contains("secret") && !notes.contains("1901"), "{name}: {notes}");
    }
}

#[test]
fn every_value() {
    for (name, entry) in entries() {
        let values = values(&volume(&entry));
        let weights = (0..values.len()).map(|i| (i % 977 + 1) as f64);
        let weighted: f64 = values.iter().zip(weights).map(|(value, weight)| value * weight).sum();
        let sum: f64 = values.iter().sum();
        // Values that are rounded may differ by the tolerance each, floats by a part of their size.
        let allowed = match entry.tolerance > 1e-3 {
            true => entry.tolerance * values.len() as f64,
            false => values.iter().map(|value| value.abs()).sum::<f64>() * entry.tolerance.max(1e-12),
        };
        assert!((sum - entry.sum).abs() <= allowed + 1e-9, "{name}: {sum}, not {}", entry.sum);
        let heaviest = 977.0;
        assert!((weighted - entry.weighted).abs() <= allowed * heaviest + 1e-6, "{name}: {weighted}");
    }
}

#[test]
fn labels_have_names_and_colours() {
    for (name, entry) in entries() {
        let Some(expected) = &entry.labels else { continue };
        let volume = volume(&entry);
        assert!(volume.contents().are_labels, "{name}");
        let labels: Vec<_> = volume.contents().labels.iter().filter(|label| label.value > 0).collect();
        assert_eq!(labels.len(), expected.len(), "{name}");
        for (label, (words, colour)) in labels.iter().zip(expected) {
            let found = label.colour.unwrap();
            let is_near = found.iter().zip(colour).all(|(a, b)| a.abs_diff(*b) <= 3);
            assert!(label.name == *words && is_near, "{name}: {label:?}");
        }
    }
}
