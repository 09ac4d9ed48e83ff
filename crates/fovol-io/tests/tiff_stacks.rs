//! TIFF stacks that tifffile wrote: `tests/reference/tiff_stacks.py` made them, and wrote down what they hold.

use fovol_core::Volume;
use fovol_io::volume::{Overrides, read};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// One channel at one time.
#[derive(Deserialize)]
struct Reference {
    channel: usize,
    time: usize,
    dims: [usize; 3],
    spacing: [f64; 3],
    units: Option<String>,
    values: Vec<f64>,
}

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/tiff")
}

fn values(volume: &Volume) -> Vec<f64> {
    let [nx, ny, nz] = volume.grid().dims();
    let voxels = (0..nz).flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z])));
    voxels.map(|voxel| volume.value(voxel)).collect()
}

fn is_near(a: [f64; 3], b: [f64; 3]) -> bool {
    (0..3).all(|axis| (a[axis] - b[axis]).abs() < 1e-6 * b[axis])
}

#[test]
fn every_channel_and_time_point_is_what_tifffile_wrote() {
    let text = std::fs::read(folder().join("stacks.json")).unwrap();
    let stacks: BTreeMap<String, Vec<Reference>> = serde_json::from_slice(&text).unwrap();
    assert!(stacks.len() > 10);
    for (name, references) in stacks {
        for Reference { channel, time, dims, spacing, units, values: expected } in &references {
            let overrides = Overrides { channel: Some(*channel), time: Some(*time), ..Overrides::default() };
            let volume = read(&folder().join(&name), &overrides).unwrap();
            assert_eq!(volume.grid().dims(), *dims, "{name}");
            assert!(is_near(volume.grid().spacing(), *spacing), "{name}: {:?}", volume.grid().spacing());
            assert_eq!(volume.units(), units.as_deref(), "{name}");
            assert_eq!(values(&volume), *expected, "{name}, channel {channel}, time {time}");
        }
        let first = read(&folder().join(&name), &Overrides::default()).unwrap();
        assert_eq!(values(&first), references[0].values, "{name} shows its first part");
        let last = references.last().unwrap();
        assert_eq!(first.contents().times, last.time + 1, "{name}");
        assert_eq!(first.contents().channels.len().max(1), last.channel + 1, "{name}");
        assert_eq!(
            first.notes().iter().any(|note| note.contains("zero is white")),
            name.starts_with("white")
        );
    }
}

#[test]
fn names_of_channels_are_listed() {
    let volume = read(&folder().join("ome_tczyx.ome.tif"), &Overrides::default()).unwrap();
    assert_eq!(volume.contents().channels, ["DAPI", "GFP"]);
    let overrides = Overrides { channel: Some(2), ..Overrides::default() };
    let error = read(&folder().join("ome_tczyx.ome.tif"), &overrides).unwrap_err().to_string();
    assert!(error.ends_with("--channel 2 is not there; it has 2 channels, 0 to 1"), "{error}");
}
