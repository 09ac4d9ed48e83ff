use super::*;
use std::fs;

/// The folder of one array of version 2, of `shape` in chunks of `chunk` bytes, and the chunk `0.0.0`.
fn array(shape: &str, chunk: &str, first: &[u8]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let metadata = format!(
        r#"{{"zarr_format": 2, "shape": {shape}, "chunks": {chunk}, "dtype": "|u1", "order": "C", "fill_value": 3,
        "compressor": null, "filters": null}}"#
    );
    fs::write(folder.path().join(".zarray"), metadata).unwrap();
    fs::write(folder.path().join("0.0.0"), first).unwrap();
    folder
}

fn refused(folder: &Path, overrides: &Overrides) -> String {
    let error = parse_folder(folder, overrides).unwrap_err().to_string();
    assert!(!error.contains('\n'), "{error}");
    error
}

#[test]
fn chunks_that_are_not_there_have_the_fill_value() {
    let folder = array("[2, 2, 3]", "[1, 2, 3]", &[9; 6]);
    let volume = parse_folder(folder.path(), &Overrides::default()).unwrap();
    assert_eq!([[0, 0, 0], [2, 1, 0], [0, 0, 1]].map(|voxel| volume.value(voxel)), [9.0, 9.0, 3.0]);
    assert_eq!((volume.format(), volume.contents().levels), ("Zarr", 1));
}

#[test]
fn sizes_that_so_few_chunks_cannot_have_are_refused() {
    let folder = array("[9000, 9000, 9000]", "[100, 100, 100]", &[]);
    fs::remove_file(folder.path().join("0.0.0")).unwrap();
    assert!(refused(folder.path(), &Overrides::default()).contains("hardly a chunk"));
    // One voxel a chunk would take days.
    let folder = array("[900, 900, 900]", "[1, 1, 1]", &[1]);
    assert!(refused(folder.path(), &Overrides::default()).contains("larger ones"));
    // A chunk that claims what it has not.
    let folder = array("[900, 900, 900]", "[900, 900, 900]", &[1]);
    assert!(refused(folder.path(), &Overrides::default()).contains("`0.0.0` is damaged"));
}

#[test]
fn choices_that_are_not_there_say_what_is() {
    let folder = array("[2, 2, 3]", "[1, 2, 3]", &[9; 6]);
    for overrides in [
        Overrides { level: Some(1), ..Overrides::default() },
        Overrides { array: Some("../x".into()), ..Overrides::default() },
        Overrides { time: Some(1), ..Overrides::default() },
    ] {
        let read = parse_folder(folder.path(), &overrides);
        let source = Source::from_bytes(folder.path(), Vec::new());
        let error = read.and_then(|volume| overrides.apply(&source, volume)).unwrap_err().to_string();
        assert!(error.contains("is not there"), "{error}");
    }
}

#[test]
fn empty_folders_and_groups_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join(".zgroup"), r#"{"zarr_format": 2}"#).unwrap();
    assert!(refused(folder.path(), &Overrides::default()).contains("holds no arrays"));
    fs::write(folder.path().join("zarr.json"), "{").unwrap();
    assert!(refused(folder.path(), &Overrides::default()).contains("its `zarr.json` is no JSON"));
}
