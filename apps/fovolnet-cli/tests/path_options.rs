//! Gives every option that takes a path something that is not a usable file. The command must answer within seconds,
//! without a panic.
#![cfg(target_os = "linux")]

mod command;

use command::{said, succeeds, within};
use std::fs;
use std::path::Path;
use std::process::Command;
use std::time::Duration;

/// Longest time for an answer, including the rendering of small pictures.
const PATIENCE: Duration = Duration::from_secs(10);

const WHAT: [&str; 5] = ["pipe", "/dev/zero", "/dev/null", "folder", "missing/file"];

/// Folder with a volume, frames, a pipe and a folder.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    succeeds(folder.path(), "data make head v.nrrd --dims 8,8,8");
    let frames = "--frames 2 --size 16x16 --keep frame,sparse,motion --reconstruct pull-push";
    succeeds(folder.path(), &format!("render v.nrrd -o frames {frames}"));
    fs::create_dir(folder.path().join("folder")).unwrap();
    pipe(&folder.path().join("pipe"));
    folder
}

fn pipe(path: &Path) {
    assert!(Command::new("mkfifo").arg(path).status().unwrap().success());
}

/// Error of `line`, which must end in time.
fn answer(folder: &Path, line: &str) -> String {
    let output = within(PATIENCE, folder, line).unwrap_or_else(|| panic!("{line}: it never ends"));
    let status = output.status.code().unwrap_or_default();
    assert!(matches!(status, 1 | 2), "{line}: {status} {}", String::from_utf8_lossy(&output.stderr));
    said(line, &output, status)
}

#[test]
fn what_is_read_is_a_file() {
    let folder = folder();
    let small = "--size 16x16 --reconstruct pull-push -o out";
    let lines = [
        "info {}".into(),
        "convert {} out.nrrd".into(),
        format!("render {{}} {small}"),
        // Session file by its name.
        format!("render {{}}.toml {small}"),
        format!("render v.nrrd {small} --tf {{}}"),
        format!("render v.nrrd {small} --tf {{}}#name"),
        format!("render v.nrrd {small} --path {{}}"),
        format!("render v.nrrd {small} --gaze {{}}"),
        "render v.nrrd --size 16x16 -o out --weights {}".into(),
        "mask -o mask.png --size 16x16 --gaze {}".into(),
        "export --weights {} --onnx out.onnx".into(),
        "reconstruct {} -o out --reconstruct pull-push".into(),
        "reconstruct frames -o out --weights {}".into(),
        "metrics {} frames".into(),
        "metrics frames {}".into(),
        "metrics frames/frame_0000.png {}".into(),
        "noise check {}".into(),
        "bench march {} --size 16x16 --repeats 1".into(),
        "bench compact {} --size 16x16 --repeats 1".into(),
        "bench pipeline {} --size 16x16".into(),
        "bench net --weights {} --size 16x16 --repeats 1".into(),
        "repro speedups --quick --size 16x16 --frames 2 --volume v.nrrd -o report --vtk {}".into(),
        "repro ablations --quick --size 16x16 --frames 2 --volume v.nrrd -o report --ablations {}".into(),
        "repro data-sets --quick --size 16x16 --frames 2 --volume {} -o report".into(),
        "repro frame-times --quick --size 16x16 --frames 2 --volume v.nrrd@{} -o report".into(),
    ];
    pipe(&folder.path().join("pipe.toml"));
    fs::create_dir(folder.path().join("folder.toml")).unwrap();
    for line in &lines {
        for what in WHAT {
            let line = line.replace("{}", what);
            let error = answer(folder.path(), &line);
            let name =
                if line.contains(&format!("{what}.toml")) { format!("{what}.toml") } else { what.into() };
            assert!(error.contains(&name), "{line}: {error}");
        }
    }
}

#[test]
fn pictures_in_folders_are_files() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    for (name, files) in [
        ("sparse", ["sparse_0.png", "x"]),
        ("frames", ["frame_0002.png", "motion_0001.exr"]),
        ("slices", ["a.png", "b.png"]),
    ] {
        let part = at("pipes").join(name);
        fs::create_dir_all(&part).unwrap();
        for file in files {
            pipe(&part.join(file));
        }
    }
    fs::create_dir_all(at("pipes/moving")).unwrap();
    for name in ["sparse_0000.png", "sparse_0001.png"] {
        fs::copy(at("frames").join(name), at("pipes/moving").join(name)).unwrap();
    }
    pipe(&at("pipes/moving/motion_0001.exr"));
    for line in [
        "reconstruct pipes/sparse -o out --reconstruct pull-push",
        "reconstruct pipes/moving -o out",
        "metrics pipes/frames pipes/frames",
        "metrics pipes/frames/frame_0002.png frames/frame_0000.png",
        "info pipes/slices",
        "render pipes/slices -o out --size 16x16",
    ] {
        let error = answer(folder.path(), line);
        assert!(error.contains("pipes/"), "{line}: {error}");
    }
}

#[test]
fn what_is_written_is_a_file_or_goes_to_somebody() {
    let folder = folder();
    let small = "--size 16x16 --reconstruct pull-push";
    let lines = [
        format!("render v.nrrd {small} -o out --json {{}}"),
        format!("render v.nrrd {small} -o out --save-session {{}}"),
        "info v.nrrd --json {}".into(),
        "data list --json {}".into(),
        "mask --size 16x16 -o {}".into(),
        "mask --size 16x16 -o mask.png --json {}".into(),
        "export --random-weights wnet-narrow --onnx {}".into(),
        "metrics frames frames --json {}".into(),
        "reconstruct frames -o out --reconstruct pull-push --json {}".into(),
        "bench march v.nrrd --size 16x16 --repeats 1 --json {}".into(),
        "bench march v.nrrd --size 16x16 --repeats 1 --picture {}".into(),
    ];
    for line in &lines {
        for what in ["pipe", "folder", "missing/file", "/dev/full"] {
            // The mask command makes its output folder, so a missing one is no error.
            if line.starts_with("mask") && line.ends_with("-o {}") && what.starts_with("missing") {
                continue;
            }
            let line = line.replace("{}", what);
            let error = answer(folder.path(), &line);
            assert!(error.contains(what), "{line}: {error}");
        }
        for what in ["/dev/null", "/dev/zero"] {
            succeeds(folder.path(), &line.replace("{}", what));
        }
    }
    for ending in ["y4m", "nrrd", "raw", "nhdr", "nii.gz", "npy"] {
        let name = format!("named-{ending}.{ending}");
        pipe(&folder.path().join(&name));
        let line = match ending {
            "y4m" => format!("render v.nrrd {small} -o out --video {name}"),
            "npy" => format!("noise make {name} --size 16 --frames 2"),
            _ => format!("convert v.nrrd {name}"),
        };
        let error = answer(folder.path(), &line);
        assert!(error.contains("nobody reads"), "{line}: {error}");
    }
    // Missing folders are made. Other kinds of files must stay unchanged.
    for what in ["pipe", "/dev/null", "/dev/zero", "v.nrrd"] {
        for line in [
            format!("render v.nrrd {small} -o {what}"),
            format!("reconstruct frames --reconstruct pull-push -o {what}"),
            format!("data get fuel -o {what}"),
            format!("demo --dims 8,8,8 --size 16x16 --frames 1 -o {what}"),
            format!("bench compact v.nrrd --size 16x16 --repeats 1 -o {what}"),
            format!("repro data-sets --quick --size 16x16 --frames 2 --volume v.nrrd -o {what}"),
        ] {
            let error = answer(folder.path(), &line);
            assert!(error.contains(what), "{line}: {error}");
        }
    }
}
