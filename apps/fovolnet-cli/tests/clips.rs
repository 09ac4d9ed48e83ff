//! Clips through ffmpeg: their contents, and messages about broken ones.

use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output};

fn is_installed(program: &str) -> bool {
    let found = Command::new(program).arg("-version").output().is_ok();
    if !found {
        println!("skipped: no {program}");
    }
    found
}

const RENDER: [&str; 11] = [
    "render",
    "marschner-lobb",
    "--dims",
    "16,16,16",
    "--size",
    "65x47",
    "--frames",
    "4",
    "--reconstruct",
    "pull-push",
    "-o",
];

fn render(out: &Path, clip: &Path, fps: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_fovolnet"));
    command.args(RENDER).arg(out).arg("--video").arg(clip).args(["--fps", fps]);
    command
}

fn succeeded(output: Output) -> String {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn clips_say_their_colours_rate_and_even_size() {
    if !is_installed("ffmpeg") || !is_installed("ffprobe") {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    for (fps, rate) in [("23.976", "24000/1001"), ("30000/1001", "30000/1001"), ("25", "25/1")] {
        let clip = folder.path().join("clip.mp4");
        succeeded(render(&out, &clip, fps).output().unwrap());
        let entries = "stream=pix_fmt,width,height,color_range,color_space,color_transfer,color_primaries,r_frame_rate,nb_read_frames";
        let mut probe = Command::new("ffprobe");
        probe.args(["-v", "error", "-count_frames", "-of", "json", "-show_entries", entries]).arg(&clip);
        let probed: Value = serde_json::from_str(&succeeded(probe.output().unwrap())).unwrap();
        let stream = &probed["streams"][0];
        for (key, value) in [
            ("pix_fmt", "yuv420p"),
            ("color_range", "tv"),
            ("color_space", "bt709"),
            ("color_transfer", "bt709"),
            ("color_primaries", "bt709"),
            ("r_frame_rate", rate),
            ("nb_read_frames", "4"),
        ] {
            assert_eq!(stream[key], value, "{key} of {stream}");
        }
        assert_eq!((stream["width"].as_u64(), stream["height"].as_u64()), (Some(66), Some(48)));
        let mut metrics = Command::new(env!("CARGO_BIN_EXE_fovolnet"));
        metrics.arg("metrics").arg(&out).arg(&clip).args(["--json", "-", "--fps", fps]);
        let compared = metrics.output().unwrap();
        let said = String::from_utf8_lossy(&compared.stderr).into_owned();
        assert!(said.contains("without their padding, as 65x47"), "{said}");
        let report: Value = serde_json::from_str(&succeeded(compared)).unwrap();
        assert!(report["psnr"].as_f64().unwrap() > 30.0, "{report}");
    }
    let wrong = render(&out, &folder.path().join("a.mp4"), "30/0").output().unwrap();
    assert_eq!(wrong.status.code(), Some(2));
}

/// Puts a false ffmpeg on the PATH. It truncates the clip that the real one wrote, and ends with status 0.
#[cfg(unix)]
#[test]
fn a_clip_that_is_cut_off_is_no_success() {
    use std::os::unix::fs::PermissionsExt;
    if !is_installed("ffmpeg") {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let path = std::env::var("PATH").unwrap();
    let script = format!(
        "#!/bin/sh\nPATH='{path}'\nffmpeg \"$@\" || exit $?\nfor last; do :; done\ncase \"$last\" in *clip*|*fovolnet-*) truncate -s 900 \"$last\";; esac\nexit 0\n"
    );
    let liar = folder.path().join("bin/ffmpeg");
    std::fs::create_dir(liar.parent().unwrap()).unwrap();
    std::fs::write(&liar, script).unwrap();
    std::fs::set_permissions(&liar, std::fs::Permissions::from_mode(0o755)).unwrap();
    for ending in ["mp4", "mkv"] {
        let clips = folder.path().join(format!("clips-{ending}"));
        std::fs::create_dir(&clips).unwrap();
        let mut run = render(&folder.path().join("out"), &clips.join(format!("clip.{ending}")), "30");
        let run = run.env("PATH", format!("{}:{path}", liar.parent().unwrap().display())).output().unwrap();
        let error = String::from_utf8_lossy(&run.stderr).into_owned();
        assert_eq!(run.status.code(), Some(1), "{ending}: {error}");
        assert!(error.contains("broken") && error.contains(&format!("clip.{ending}")), "{error}");
        assert_eq!(std::fs::read_dir(&clips).unwrap().count(), 0, "{ending}");
    }
}

#[cfg(unix)]
#[test]
fn clips_that_reach_a_limit_are_errors_and_leave_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let clips = folder.path().join("clips");
    std::fs::create_dir(&clips).unwrap();
    for ending in ["y4m", "mp4"] {
        if ending == "mp4" && !is_installed("ffmpeg") {
            continue;
        }
        let clip = clips.join(format!("clip.{ending}"));
        let mut run = Command::new("sh");
        // A limit of 512 bytes: a blank frame fits, its clip does not.
        run.args(["-c", "ulimit -f 1; exec \"$0\" \"$@\"", env!("CARGO_BIN_EXE_fovolnet")]);
        run.args([
            "render",
            "marschner-lobb",
            "--dims",
            "16,16,16",
            "--size",
            "64x48",
            "--camera",
            "0,0,9,0,0,20,35",
        ]);
        run.args(["--device", "cpu", "-o"]).arg(folder.path().join("out")).arg("--video").arg(&clip);
        let run = run.output().unwrap();
        let error = String::from_utf8_lossy(&run.stderr).into_owned();
        assert_eq!(run.status.code(), Some(1), "{ending}: {error}");
        assert!(error.contains(&format!("clip.{ending}")), "{error}");
        assert_eq!(std::fs::read_dir(&clips).unwrap().count(), 0, "{ending}: {error}");
    }
}
