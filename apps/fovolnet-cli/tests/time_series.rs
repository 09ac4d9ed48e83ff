//! Time series of files, and clips over time.

use std::path::Path;
use std::process::{Command, Output};

fn run(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_fovolnet"));
    command.args(arguments).current_dir(folder).env("PATH", "").output().unwrap()
}

fn text(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

/// Three volumes that grow brighter, in a folder `run`.
fn series() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("run")).unwrap();
    for time in 1..=3u8 {
        let name = format!("run/step_{}_12x12x12_uint8.raw", 4 * time);
        std::fs::write(folder.path().join(name), [60 * time; 1728]).unwrap();
    }
    folder
}

const SMALL: [&str; 8] = ["--size", "24x16", "--device", "cpu", "--tf", "grey", "--sampling", "full"];

/// Sum of all bytes of a decoded picture.
fn brightness(path: &Path) -> f32 {
    fovolnet::io::image::read(path).unwrap().pixels().iter().map(|[r, g, b, _]| r + g + b).sum()
}

#[test]
fn a_clip_has_a_frame_for_every_time_point() {
    let folder = series();
    for volume in ["run", "run/step_*.raw"] {
        let output =
            run(folder.path(), &[&["render", volume, "-o", "clip", "--time", "all"], &SMALL[..]].concat());
        assert!(output.status.success(), "{}", text(&output));
        let frames: Vec<f32> =
            (0..3).map(|i| brightness(&folder.path().join(format!("clip/frame_{i:04}.png")))).collect();
        assert!(frames[0] < 0.95 * frames[1] && frames[1] < 0.95 * frames[2], "{frames:?}");
        assert!(!folder.path().join("clip/frame_0003.png").exists());
        std::fs::remove_dir_all(folder.path().join("clip")).unwrap();
    }
}

#[test]
fn one_time_point_is_a_picture_and_a_session_replays_a_clip() {
    let folder = series();
    let output =
        run(folder.path(), &[&["render", "run", "-o", "one.png", "--time", "2"], &SMALL[..]].concat());
    assert!(output.status.success(), "{}", text(&output));
    let saved = ["render", "run", "-o", "clip", "--time", "1..2", "--save-session", "s.toml"];
    let output = run(folder.path(), &[&saved, &SMALL[..]].concat());
    assert!(output.status.success(), "{}", text(&output));
    let output = run(folder.path(), &["render", "s.toml", "-o", "again"]);
    assert!(output.status.success(), "{}", text(&output));
    let bytes = |name: &str| std::fs::read(folder.path().join(name)).unwrap();
    assert_eq!(bytes("clip/frame_0001.png"), bytes("again/frame_0001.png"));
    assert_eq!(bytes("clip/frame_0001.png"), bytes("one.png"));
}

#[test]
fn what_is_not_there_is_said() {
    let folder = series();
    let said = |more: &[&str]| {
        let output = run(folder.path(), &[&["render", "run", "-o", "x"], more].concat());
        assert_eq!(output.status.code(), Some(1), "{}", text(&output));
        text(&output)
    };
    assert!(said(&["--time", "1..3"]).contains("3 time points"));
    assert!(said(&["--time", "7"]).contains("--time"));
    assert!(said(&["--time", "all", "--budget", "50"]).contains("no planner"));
    let output = run(folder.path(), &["info", "run/none_*.raw"]);
    assert!(text(&output).contains("no file has such a name"), "{}", text(&output));
}
