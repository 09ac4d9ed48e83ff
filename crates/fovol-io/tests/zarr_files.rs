//! Zarr, OME-Zarr and TIFF files that zarr-python, ome-zarr, xarray and tifffile wrote: `tests/reference/zarr_files.py`
//! made them, and wrote down what they hold.
#![cfg(feature = "zarr")]

use fovol_core::Volume;
use fovol_io::volume::{Overrides, read};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Content of a file for one choice of the user.
#[derive(Deserialize)]
struct Reference {
    array: Option<String>,
    time: Option<usize>,
    channel: Option<usize>,
    component: Option<usize>,
    level: Option<usize>,
    dims: [usize; 3],
    spacing: [f64; 3],
    levels: usize,
    channels: usize,
    times: usize,
    names: Option<Vec<String>>,
    origin: Option<[f64; 3]>,
    range: Option<[f64; 2]>,
    /// One in seven values; missing ones are not finite.
    values: Vec<Option<f64>>,
}

impl Reference {
    fn overrides(&self) -> Overrides {
        let Self { array, time, channel, component, level, .. } = self;
        Overrides {
            array: array.clone(),
            time: *time,
            channel: *channel,
            component: *component,
            level: *level,
            ..Overrides::default()
        }
    }

    fn check(&self, name: &str, volume: &Volume) {
        let contents = volume.contents();
        assert_eq!(volume.grid().dims(), self.dims, "{name}");
        assert_eq!(
            (contents.levels, contents.channels.len().max(1), contents.times),
            (self.levels, self.channels, self.times),
            "{name}"
        );
        assert!(are_near(&volume.grid().spacing(), &self.spacing), "{name}: {:?}", volume.grid());
        if let Some(names) = &self.names {
            assert_eq!(&contents.channels, names, "{name}");
        }
        if let Some(range) = self.range {
            assert_eq!(volume.range(), range, "{name}");
        }
        if let Some(origin) = self.origin {
            assert!(are_near(&volume.placement().unwrap().origin().to_array(), &origin), "{name}");
        }
        let found = values(volume);
        let is_near = |(found, expected): (&f64, &Option<f64>)| match expected {
            Some(expected) => (found - expected).abs() <= 1e-6 * expected.abs().max(1.0),
            None => !found.is_finite(),
        };
        assert_eq!(found.len(), self.values.len(), "{name}");
        assert!(found.iter().zip(&self.values).all(is_near), "{name}: {found:?}");
    }
}

fn are_near(found: &[f64; 3], expected: &[f64; 3]) -> bool {
    found.iter().zip(expected).all(|(a, b)| (a - b).abs() <= 1e-6 * b.abs())
}

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/zarr_files")
}

fn values(volume: &Volume) -> Vec<f64> {
    let [nx, ny, nz] = volume.grid().dims();
    let voxels = (0..nz).flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z])));
    voxels.map(|voxel| volume.value(voxel)).step_by(7).collect()
}

#[test]
fn every_file_is_what_other_programs_wrote() {
    let text = std::fs::read(folder().join("values.json")).unwrap();
    let files: BTreeMap<String, Vec<Reference>> = serde_json::from_slice(&text).unwrap();
    assert!(files.len() > 30);
    for (name, references) in files {
        for reference in references {
            let volume = read(&folder().join(&name), &reference.overrides());
            reference.check(&name, &volume.unwrap_or_else(|e| panic!("{e}")));
        }
    }
}
