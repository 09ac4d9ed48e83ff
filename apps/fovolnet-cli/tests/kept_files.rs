//! No command destroys its inputs or replaces a file that the user did not name.

mod command;

use command::{fails, succeeds};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// All files below `folder` with their contents.
fn contents(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(contents(&path));
        } else {
            found.insert(path.clone(), fs::read(&path).unwrap());
        }
    }
    found
}

/// Runs each of `lines` in `folder`. Each must be refused as a contradiction, name the file in danger, and change
/// nothing.
fn refuses(folder: &Path, lines: &[&str]) {
    let before = contents(folder);
    for line in lines {
        let error = fails(folder, line, 2);
        assert!(error.contains("another name"), "{line}: {error}");
        assert!(contents(folder) == before, "{line}: files have changed");
    }
}

/// Folder with one input of each kind.
fn inputs() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    for volume in ["a.nrrd", "b.nhdr", "c.mhd", "d.raw"] {
        succeeds(folder.path(), &format!("data make head {volume} --dims 8,8,8"));
    }
    fs::write(at("tf.json"), r#"{"points":[[0,0,0,0,0],[1,1,0.5,0.2,0.3]]}"#).unwrap();
    let key = "[[keyframe]]\nframe = 0\neye = [0, 0, 2]\ntarget = [0, 0, 0]\nfovy = 35\n";
    fs::write(at("path.toml"), key).unwrap();
    fs::write(at("gaze.toml"), "stops = [[0, 0.1, 0.2]]\n").unwrap();
    let shipped =
        concat!(env!("CARGO_MANIFEST_DIR"), "/../../crates/fovol-net/assets/weights/wnet-fast.safetensors");
    fs::copy(shipped, at("w.safetensors")).unwrap();
    succeeds(folder.path(), "noise make noise.npy --size 16 --frames 2");
    let render = "--size 16x16 --save-session s.toml --keep frame,sparse --reconstruct pull-push";
    succeeds(folder.path(), &format!("render a.nrrd -o frames {render}"));
    fs::create_dir(at("slices")).unwrap();
    for name in ["1.png", "2.png"] {
        fs::copy(at("frames/frame_0000.png"), at("slices").join(name)).unwrap();
    }
    folder
}

const SMALL: &str = "--size 16x16 --reconstruct pull-push";

#[test]
fn inputs_are_no_outputs() {
    let folder = inputs();
    let render = |rest: &str| format!("render {rest} {SMALL}");
    let lines = [
        render("a.nrrd -o out --save-session a.nrrd"),
        render("a.nrrd -o out --json a.nrrd"),
        render("a.nrrd -o out --json ./out/../a.nrrd"),
        render("b.nhdr -o out --json b.raw"),
        render("c.mhd -o out --json c.raw"),
        render("d.raw -o out --json d.json"),
        render("s.toml -o out --save-session s.toml"),
        render("s.toml -o out --json a.nrrd"),
        render("head --dims 8,8,8 --tf tf.json -o out --json tf.json"),
        render("head --dims 8,8,8 --path path.toml -o out --save-session path.toml"),
        render("head --dims 8,8,8 --gaze gaze.toml -o out --json gaze.toml"),
        "render head --dims 8,8,8 --size 16x16 --weights w.safetensors -o out --json w.safetensors".into(),
        "convert a.nrrd a.nrrd".into(),
        "convert b.nhdr b.raw".into(),
        "convert d.raw d.nhdr".into(),
        "convert d.raw d.nhdr --overwrite".into(),
        "info a.nrrd --json a.nrrd".into(),
        "info slices --json slices/2.png".into(),
        "convert slices slices/1.png".into(),
        "mask -o gaze.toml --gaze gaze.toml --size 16x16".into(),
        "mask -o mask.png --gaze gaze.toml --size 16x16 --json gaze.toml".into(),
        "noise check noise.npy --json noise.npy".into(),
        "export --weights w.safetensors --onnx w.safetensors".into(),
        "metrics frames frames --json frames/frame_0000.png".into(),
        "metrics frames/frame_0000.png frames/frame_0000.png --json frames/frame_0000.png".into(),
        "reconstruct frames -o full --reconstruct pull-push --json frames/sparse_0000.png".into(),
        "bench march a.nrrd --size 16x16 --repeats 1 --picture a.nrrd".into(),
        "bench march a.nrrd --size 16x16 --repeats 1 --json a.nrrd".into(),
        "bench compact a.nrrd --size 16x16 --repeats 1 --json a.nrrd".into(),
        "bench pipeline a.nrrd --size 16x16 --json a.nrrd".into(),
        "repro ablations --quick -o report --ablations s.toml --json s.toml".into(),
    ];
    refuses(folder.path(), &lines.each_ref().map(String::as_str));
}

#[cfg(unix)]
#[test]
fn links_lead_to_inputs_too() {
    use std::os::unix::fs::symlink;
    let folder = inputs();
    let at = |name: &str| folder.path().join(name);
    symlink("a.nrrd", at("link.json")).unwrap();
    fs::hard_link(at("a.nrrd"), at("twin.json")).unwrap();
    symlink("d.raw", at("e.raw")).unwrap();
    fs::create_dir(at("out")).unwrap();
    symlink("../a.nrrd", at("out/frame_0000.png")).unwrap();
    fs::create_dir(at("full")).unwrap();
    fs::hard_link(at("frames/sparse_0000.png"), at("full/frame_0000.png")).unwrap();
    let lines = [
        format!("render a.nrrd -o elsewhere --json link.json {SMALL}"),
        format!("render a.nrrd -o elsewhere --json twin.json {SMALL}"),
        format!("render twin.json -o elsewhere --json a.nrrd {SMALL}"),
        format!("render a.nrrd -o out {SMALL}"),
        "convert e.raw d.raw --dims 8,8,8 --dtype u8".into(),
        "convert d.raw e.nhdr --overwrite".into(),
        "reconstruct frames -o full --reconstruct pull-push".into(),
    ];
    refuses(folder.path(), &lines.each_ref().map(String::as_str));
}

#[test]
fn two_outputs_are_two_files() {
    let folder = tempfile::tempdir().unwrap();
    for line in [
        "render head --dims 8,8,8 --size 16x16 -o out --json out/frame_0000.png",
        "render head --dims 8,8,8 --size 16x16 -o out.png --save-session out.png",
        "render head --dims 8,8,8 --size 16x16 -o out --save-session x.toml --json ./x.toml",
        "mask -o mask.png --size 16x16 --json mask.png",
    ] {
        let error = fails(folder.path(), line, 2);
        assert!(error.contains("two outputs"), "{line}: {error}");
        assert!(contents(folder.path()).is_empty(), "{line}");
    }
}

#[test]
fn files_that_nobody_named_stay_unless_a_flag_gives_them_up() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    succeeds(folder.path(), "data make engine v.nrrd --dims 8,8,8");
    let made = "data make head scan.{} --dims 8,8,8";
    let converted = "convert v.nrrd scan.{}";
    for line in [made, converted] {
        for (ending, second) in [("nhdr", "scan.raw"), ("mhd", "scan.raw"), ("raw", "scan.json")] {
            fs::write(at(second), "of somebody").unwrap();
            let line = line.replace("{}", ending);
            let error = fails(folder.path(), &line, 1);
            assert!(error.contains(second) && error.contains("--overwrite"), "{line}: {error}");
            assert_eq!(fs::read(at(second)).unwrap(), b"of somebody");
            assert!(!at("scan").with_extension(ending).exists(), "{line}");
            succeeds(folder.path(), &format!("{line} --overwrite"));
            assert_ne!(fs::read(at(second)).unwrap(), b"of somebody");
            // The command wrote this file itself, so it may replace it.
            succeeds(folder.path(), &line);
            succeeds(folder.path(), &format!("info scan.{ending}"));
            for file in ["scan.raw", "scan.json", "scan.nhdr", "scan.mhd"] {
                let _ = fs::remove_file(at(file));
            }
        }
    }
}
