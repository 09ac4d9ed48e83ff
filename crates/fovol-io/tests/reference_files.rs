//! Real volume files, read here and by outside libraries: `tests/reference/volume_info.py` wrote down what
//! those say. Prints one line per file, from which `docs/formats.md` is made.
//!
//! `tests/reference/volume_variants.py` runs this test over files of its own by `FOVOL_TEST_REFERENCES` and
//! `FOVOL_TEST_DATA`, and has each written again into the folder `FOVOL_TEST_WRITTEN`.

use fovol_core::Volume;
use fovol_io::volume::{Overrides, read, write};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Reference result of an outside library for one file.
#[derive(Deserialize)]
#[serde(untagged)]
enum Reference {
    /// No library can read it, or we do not on purpose.
    Refused {
        /// Why.
        error: String,
    },
    /// It is a volume.
    Volume {
        dims: [usize; 3],
        dtype: String,
        components: usize,
        spacing: Option<[f64; 3]>,
        min: f64,
        max: f64,
        mean: f64,
    },
}

#[test]
fn files_are_read_as_outside_libraries_read_them() {
    let Some(data) = test_data() else { return };
    let json = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/reference/volume_info.json");
    let json = std::env::var_os("FOVOL_TEST_REFERENCES").map_or_else(|| json.into(), PathBuf::from);
    let references: BTreeMap<String, Reference> =
        serde_json::from_slice(&std::fs::read(json).unwrap()).unwrap();
    let mut wrong = Vec::new();
    for (name, reference) in &references {
        let path = data.join(name);
        if !path.exists() {
            println!("skipped: {name} is not in the test data");
            continue;
        }
        let outcome = compare(&path, reference);
        let said = outcome.as_ref().unwrap_or_else(|said| said);
        println!("outcome {name}: {said}");
        if outcome.is_err() {
            wrong.push(format!("{name}: {said}"));
        }
    }
    assert!(wrong.is_empty(), "{} files differ:\n{}", wrong.len(), wrong.join("\n"));
}

/// Writes `volume` in every format that has its type, for outside libraries to read.
fn write_again(volume: &Volume, name: &str) {
    let Some(folder) = std::env::var_os("FOVOL_TEST_WRITTEN").map(PathBuf::from) else { return };
    for ending in ["nrrd", "nhdr", "mha", "mhd", "nii", "nii.gz", "vti"] {
        // Detached voxels of two headers must not share a name.
        let path = folder.join(format!("{name}~{}.{ending}", ending.replace('.', "_")));
        match write(volume, &path) {
            Ok(_) | Err(fovol_io::Error::Unsupported { .. }) => {}
            Err(error) => panic!("{error}"),
        }
    }
}

/// One line on how our reader does on `path`; `Err` when that is not what the reference says.
fn compare(path: &Path, reference: &Reference) -> Result<String, String> {
    match (read(path, &Overrides::default()), reference) {
        (Ok(volume), Reference::Volume { .. }) => {
            let differences = differences(&volume, reference);
            write_again(&volume, &path.file_name().unwrap_or_default().to_string_lossy());
            if differences.is_empty() { Ok("agrees".into()) } else { Err(differences.join("; ")) }
        }
        (Ok(volume), Reference::Refused { error }) => {
            Err(format!("was read as {:?}, though {error}", volume.grid()))
        }
        (Err(error), Reference::Volume { .. }) => Err(format!("could not be read: {error}")),
        (Err(error), Reference::Refused { .. }) => {
            let message = error.to_string();
            let is_one_line = !message.contains('\n') && message.len() > 20;
            if is_one_line {
                Ok(format!("refused: {message}"))
            } else {
                Err(format!("bad message: {message}"))
            }
        }
    }
}

fn differences(volume: &Volume, reference: &Reference) -> Vec<String> {
    let Reference::Volume { dims, dtype, components, spacing, min, max, mean } = reference else {
        return Vec::new();
    };
    let statistics = volume.statistics();
    let mut found = Vec::new();
    let mut check = |holds: bool, text: String| {
        if !holds {
            found.push(text);
        }
    };
    check(volume.grid().dims() == *dims, format!("dims {:?}, not {dims:?}", volume.grid().dims()));
    check(volume.dtype().name() == dtype, format!("type {}, not {dtype}", volume.dtype()));
    check(
        volume.components() == *components,
        format!("{} components, not {components}", volume.components()),
    );
    if let Some(spacing) = spacing {
        let ours = volume.grid().spacing();
        let is_close = ours.iter().zip(spacing).all(|(a, b)| (a - b).abs() <= 1e-6 * b.abs());
        check(is_close, format!("spacing {ours:?}, not {spacing:?}"));
    }
    check(statistics.min == *min, format!("minimum {}, not {min}", statistics.min));
    check(statistics.max == *max, format!("maximum {}, not {max}", statistics.max));
    // Means near zero are sums that cancel: what matters is their error against the values.
    let scale = mean.abs().max((max - min) * 1e-3);
    check((statistics.mean - mean).abs() <= 1e-6 * scale, format!("mean {}, not {mean}", statistics.mean));
    found
}

/// The test data: `FOVOL_TEST_DATA`, or `../shared/data` beside the repository.
fn test_data() -> Option<PathBuf> {
    let beside = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data");
    let folder = std::env::var_os("FOVOL_TEST_DATA").map_or_else(|| beside.into(), PathBuf::from);
    if folder.is_dir() {
        return Some(folder);
    }
    println!("skipped: no data at {}; set FOVOL_TEST_DATA", folder.display());
    None
}
