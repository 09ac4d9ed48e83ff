//! File names that are not Unicode, which Linux allows, wherever the command takes one.
#![cfg(target_os = "linux")]

use serde_json::Value;
use std::ffi::{OsStr, OsString};
use std::fs;
use std::os::unix::ffi::{OsStrExt, OsStringExt};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn fovolnet(arguments: &[&OsStr]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_fovolnet")).args(arguments).output().unwrap()
}

/// Standard output of a run that must succeed.
fn succeeds(arguments: &[&OsStr]) -> String {
    let output = fovolnet(arguments);
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("what is printed is Unicode")
}

/// Arguments of a command; `{}` stands for the next of `files`.
fn words<'a>(command: &'a str, files: &[&'a Path]) -> Vec<&'a OsStr> {
    let mut files = files.iter();
    let word = |word: &'a str| match word {
        "{}" => files.next().expect("a file for each place").as_os_str(),
        word => OsStr::new(word),
    };
    command.split_whitespace().map(word).collect()
}

fn run(command: &str, files: &[&Path]) -> String {
    succeeds(&words(command, files))
}

/// Path in `folder` of a name with the invalid byte 0xff between `before` and `after`.
fn named(folder: &Path, before: &str, after: &str) -> PathBuf {
    folder.join(OsString::from_vec([before.as_bytes(), b"\xff", after.as_bytes()].concat()))
}

fn volume(folder: &Path) -> PathBuf {
    let volume = named(folder, "scan", ".nrrd");
    run("convert head {} --dims 16,16,16", &[&volume]);
    assert!(volume.is_file(), "the name is written as it was given");
    volume
}

#[test]
fn volumes_are_read_and_written() {
    let folder = tempfile::tempdir().unwrap();
    let volume = volume(folder.path());
    let report: Value = serde_json::from_str(&run("info {} --json -", &[&volume])).unwrap();
    assert_eq!(report["dims"], serde_json::json!([16, 16, 16]));
    assert!(run("info {}", &[&volume]).contains(r"scan\xff.nrrd"));
    for ending in [".nii.gz", ".mha", ".vti", "_16x16x16_uint8.raw"] {
        let other = named(folder.path(), "other", ending);
        run("convert {} {}", &[&volume, &other]);
        let found: Value = serde_json::from_str(&run("info {} --json -", &[&other])).unwrap();
        assert_eq!(found["histogram"], report["histogram"], "{ending}");
    }
    // Headers in plain text cannot name such a file.
    let output = fovolnet(&words("convert {} {}", &[&volume, &named(folder.path(), "x", ".nhdr")]));
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(
        output.status.code() == Some(1) && said.contains("use letters") && said.lines().count() == 1,
        "{said}"
    );
}

#[test]
fn pairs_of_header_and_image_are_found() {
    let folder = tempfile::tempdir().unwrap();
    let single = named(folder.path(), "single", ".nii");
    run("convert head {} --dims 8,8,8", &[&single]);
    let (header, image) = (named(folder.path(), "pair", ".hdr"), named(folder.path(), "pair", ".img"));
    // NIfTI in two files: the voxels begin at 0, and the magic word is `ni1`.
    let mut bytes = fs::read(&single).unwrap();
    let offset = f32::from_le_bytes(bytes[108..112].try_into().unwrap()) as usize;
    fs::write(&image, &bytes[offset..]).unwrap();
    bytes[108..112].copy_from_slice(&0f32.to_le_bytes());
    bytes[344..348].copy_from_slice(b"ni1\0");
    fs::write(&header, &bytes[..348]).unwrap();
    let histogram = |file: &Path| {
        let report: Value = serde_json::from_str(&run("info {} --json -", &[file])).unwrap();
        report["histogram"].clone()
    };
    assert_eq!(histogram(&header), histogram(&single));
    assert_eq!(histogram(&image), histogram(&single));
}

#[test]
fn sessions_find_their_files_again() {
    let folder = tempfile::tempdir().unwrap();
    let volume = volume(folder.path());
    let weights = named(folder.path(), "w", ".safetensors");
    let shipped =
        concat!(env!("CARGO_MANIFEST_DIR"), "/../../crates/fovol-net/assets/weights/wnet-fast.safetensors");
    fs::copy(shipped, &weights).unwrap();
    let colours = named(folder.path(), "colours", ".json");
    fs::write(&colours, r#"{"points":[[0,0,0,0,0],[1,1,0.5,0.2,0.3]]}"#).unwrap();
    let [out, again] = ["out", "again"].map(|name| named(folder.path(), name, ""));
    let [session, report] = [".toml", ".json"].map(|ending| named(folder.path(), "made", ending));
    run(
        "render {} -o {} --size 64x48 --weights {} --tf {} --save-session {} --json {}",
        &[&volume, &out, &weights, &colours, &session, &report],
    );
    let text = fs::read_to_string(&session).expect("sessions are Unicode");
    assert!(text.contains(r"scan\xff.nrrd") && text.contains(r"w\xff.safetensors"), "{text}");
    let report: Value = serde_json::from_slice(&fs::read(&report).unwrap()).unwrap();
    assert!(report["volume"].as_str().unwrap().ends_with("scan\u{fffd}.nrrd"), "{report}");
    run("render {} -o {}", &[&session, &again]);
    let [first, second] = [out, again].map(|folder| fs::read(folder.join("frame_0000.png")).unwrap());
    assert_eq!(first, second);
    // Files that moved together with their session are found.
    let moved = named(folder.path(), "moved", "");
    fs::create_dir(&moved).unwrap();
    for file in [&volume, &weights, &session] {
        fs::copy(file, moved.join(file.file_name().unwrap())).unwrap();
        fs::remove_file(file).unwrap();
    }
    run("render {} -o {}", &[&moved.join(session.file_name().unwrap()), &named(folder.path(), "third", "")]);
    let third = fs::read(named(folder.path(), "third", "").join("frame_0000.png")).unwrap();
    assert_eq!(third, first);
}

#[test]
fn a_name_with_a_backslash_is_another_file() {
    let folder = tempfile::tempdir().unwrap();
    let volume = volume(folder.path());
    let other = folder.path().join(r"scan\xff.nrrd");
    run("convert head {} --dims 9,8,7", &[&other]);
    let dims = |file: &Path| {
        let report: Value = serde_json::from_str(&run("info {} --json -", &[file])).unwrap();
        report["dims"].clone()
    };
    assert_eq!(dims(&volume), serde_json::json!([16, 16, 16]));
    assert_eq!(dims(&other), serde_json::json!([9, 8, 7]));
}

#[test]
fn every_command_takes_them() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str, ending: &str| named(folder.path(), name, ending);
    let volume = volume(folder.path());
    run("mask -o {} --size 64x48", &[&at("mask", ".png")]);
    run(
        "render {} -o {} --size 64x48 --frames 2 --keep sparse,frame --video {}",
        &[&volume, &at("frames", ""), &at("clip", ".y4m")],
    );
    run("reconstruct {} -o {} --reconstruct pull-push", &[&at("frames", ""), &at("full", "")]);
    assert!(at("full", "").join("frame_0001.png").is_file());
    run("metrics {} {} --json {}", &[&at("frames", ""), &at("clip", ".y4m"), &at("metrics", ".json")]);
    run("bench march {} --size 64x48 --repeats 1", &[&volume]);
    run("export --random-weights wnet-narrow --onnx {}", &[&at("net", ".onnx")]);
    assert!(at("net", ".onnx").is_file());
}

#[test]
fn what_is_missing_is_said_in_one_line() {
    let name = OsStr::from_bytes(b"no\xffsuch.nrrd");
    let output = fovolnet(&[OsStr::new("info"), name]);
    let said = String::from_utf8(output.stderr).expect("messages are Unicode");
    assert_eq!(output.status.code(), Some(1));
    assert!(said.starts_with("error: ") && said.contains("such.nrrd") && said.lines().count() == 1, "{said}");
}
