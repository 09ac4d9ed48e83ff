//! Too little memory: one line of error, status 1, and nothing left behind.

mod command;

use command::{run, said, succeeds};
use serde_json::Value;
use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::fs;
use std::io::Write;
use std::path::Path;
use std::process::{Command, Output, Stdio};

/// Smallest size in bytes of the allocations that fail, one in each run. The tests' volumes, grids and frames are
/// larger.
const LARGE: usize = 1 << 18;
/// Upper bound of the large allocations of any command here.
const MOST: usize = 100;

/// Files in `folder` and below, with their contents.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut all = BTreeMap::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if path.is_dir() {
            all.extend(files(&path).into_iter().map(|(below, bytes)| (format!("{name}/{below}"), bytes)));
        } else {
            all.insert(name, fs::read(&path).unwrap());
        }
    }
    all
}

/// Runs the command `line` in `folder` and lets its large allocation number `nth` fail.
fn refusing(nth: usize, folder: &Path, line: &str) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_fovolnet"));
    command.args(line.split_whitespace().map(OsStr::new)).current_dir(folder).stdin(Stdio::null());
    command.env("FOVOLNET_REFUSE_ALLOCATION", format!("{nth}:{LARGE}")).output().unwrap()
}

/// Lets each large allocation of the command `line` fail once, in folders with the files `inputs`. The command must
/// make at least `least` large allocations. Files that exist afterwards must be complete, as in an undisturbed run.
fn refuse_each(line: &str, inputs: &Path, least: usize) {
    let folder = || {
        let folder = tempfile::tempdir().unwrap();
        for (name, bytes) in files(inputs) {
            fs::create_dir_all(folder.path().join(&name).parent().unwrap()).unwrap();
            fs::write(folder.path().join(name), bytes).unwrap();
        }
        folder
    };
    let whole = folder();
    succeeds(whole.path(), line);
    let complete = files(whole.path());
    for nth in 1..MOST {
        let folder = folder();
        let output = refusing(nth, folder.path(), line);
        if output.status.success() {
            assert!(nth > least, "{line}: only {} large allocations", nth - 1);
            return;
        }
        let error = said(&format!("{line} ({nth})"), &output, 1);
        assert!(error.contains("out of memory"), "{line} ({nth}): {error}");
        for (name, bytes) in files(folder.path()) {
            let expected = complete.get(&name);
            assert!(expected == Some(&bytes), "{line} ({nth}): {name} is left behind, or not complete");
        }
    }
    panic!("{line}: there is no end of large allocations");
}

#[test]
fn rendering_survives_every_refusal_in_every_mode_of_shadows() {
    let nothing = tempfile::tempdir().unwrap();
    for shadows in ["off", "on", "cached"] {
        let line = format!(
            "render head --dims 64,64,64 --size 160x120 --sampling full --shadows {shadows} --device cpu -o out"
        );
        refuse_each(&line, nothing.path(), 4);
    }
}

#[test]
fn networks_clips_and_references_survive_every_refusal() {
    let nothing = tempfile::tempdir().unwrap();
    let line = "render marschner-lobb --dims 48,48,48 --size 160x120 --frames 2 --path flythrough --pb 0.2 --device cpu \
                --reconstruct wnet --precision f32 --keep frame,sparse,reference,motion --format exr --video out/clip.y4m -o out";
    refuse_each(line, nothing.path(), 10);
    if !fovolnet::io::video::ffmpeg_installed() {
        println!("skipped: no ffmpeg");
        return;
    }
    let line = "render marschner-lobb --dims 16,16,16 --size 160x120 --frames 2 --reconstruct pull-push --device cpu \
                --video out/clip.mp4 -o out";
    refuse_each(line, nothing.path(), 4);
}

#[test]
fn volumes_survive_every_refusal() {
    let folder = tempfile::tempdir().unwrap();
    succeeds(folder.path(), "data make head in.nii.gz --dims 64,64,48");
    refuse_each("convert in.nii.gz out.vti", folder.path(), 2);
    refuse_each("convert in.nii.gz out.nrrd --downsample 2", folder.path(), 2);
    refuse_each("info in.nii.gz", folder.path(), 2);
    succeeds(folder.path(), "data make engine bare_96x96x64_uint8.raw.gz --dims 96,96,64");
    refuse_each("info bare_96x96x64_uint8.raw.gz", folder.path(), 1);
    refuse_each("data make engine out.mha --dims 80,80,64", folder.path(), 1);
    refuse_each("noise make out.npy --size 64 --frames 16", folder.path(), 3);
}

#[test]
fn frames_of_others_and_comparisons_survive_every_refusal() {
    let folder = tempfile::tempdir().unwrap();
    succeeds(
        folder.path(),
        "render head --dims 16,16,16 --size 192x160 --frames 2 --path flythrough --device cpu --keep sparse,reference \
         --video clip.y4m -o in",
    );
    refuse_each("reconstruct in -o out --device cpu", folder.path(), 4);
    refuse_each("reconstruct in -o out --device cpu --reconstruct pull-push", folder.path(), 2);
    refuse_each("metrics in clip.y4m --json out.json", folder.path(), 4);
}

/// Runs the command `line` in `folder` with at most `kilobytes` of address space.
#[cfg(target_os = "linux")]
fn within(kilobytes: u64, folder: &Path, line: &str) -> Output {
    let mut command = Command::new("sh");
    command.args([
        "-c",
        &format!("ulimit -v {kilobytes}; exec \"$0\" \"$@\""),
        env!("CARGO_BIN_EXE_fovolnet"),
    ]);
    command.args(line.split_whitespace()).current_dir(folder).stdin(Stdio::null()).output().unwrap()
}

/// Makes a sparse file of `gigabytes` of zeros, which takes no disk space.
#[cfg(target_os = "linux")]
fn zeros(path: &Path, gigabytes: u64) {
    fs::File::create(path).unwrap().set_len(gigabytes << 30).unwrap();
}

#[cfg(target_os = "linux")]
#[test]
fn what_cannot_fit_is_refused_with_what_helps() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    zeros(&at.join("big_1024x1024x1024_uint8.raw"), 1);
    for (kilobytes, line, parts) in [
        (
            1 << 20,
            "render head --size 16384x16384 --device cpu -o out",
            ["frames 8.6 GB", "a smaller --size"],
        ),
        (
            1 << 20,
            "render head --size 16384x16384 --frames 9 --device cpu -o out",
            ["frames 8.6 GB", "--size"],
        ),
        (
            1 << 20,
            "render head --dims 32,32,32 --size 5000x4000 --keep frame,reference --device cpu -o out",
            ["references", "a smaller --size"],
        ),
        (
            1 << 20,
            "render head --dims 32,32,32 --size 4000x3000 --frames 2 --pb 0.01 --reconstruct wnet --weights wnet-paper --precision f32 \
             --device cpu -o out",
            ["its tensors", "a smaller --size"],
        ),
        (
            1_500_000,
            "render big_1024x1024x1024_uint8.raw --size 64x64 --sampling full --device cpu -o out",
            ["voxels in bricks 1.5 GB", "--downsample 2"],
        ),
        (1 << 20, "info big_1024x1024x1024_uint8.raw", ["opening the file", "ulimit -v"]),
        (1 << 20, "data make head out.nrrd --dims 1024,1024,1024", ["voxels 2.1 GB", "smaller --dims"]),
        (300_000, "noise make out.npy --size 256 --frames 256", ["energies 403 MB", "fewer --frames"]),
        (1 << 20, "bench march head --size 8192x8192 --device cpu", ["frames 2.1 GB", "--size"]),
    ] {
        let error = said(line, &within(kilobytes, at, line), 1);
        assert!(error.contains("out of memory"), "{line}: {error}");
        assert!(parts.iter().all(|part| error.contains(part)), "{line}: {error}");
        assert!(error.contains("are available"), "{line}: {error}");
    }
    let left: Vec<String> = files(&at.join("out")).into_keys().collect();
    assert!(left.is_empty(), "{left:?}");
    // The advice of the error must work.
    let small =
        "render big_1024x1024x1024_uint8.raw --size 64x64 --sampling full --downsample 8 --device cpu -o out";
    let output = within(1_500_000, at, small);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[cfg(target_os = "linux")]
#[test]
fn no_limit_however_tight_is_more_than_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let line = "render head --dims 48,48,48 --size 320x200 --frames 2 --device cpu -o out";
    let mut succeeded = false;
    // With less than the first value the system cannot even load the program.
    for kilobytes in (64_000..176_000).step_by(2_000) {
        let output = within(kilobytes, folder.path(), line);
        succeeded |= output.status.success();
        if !output.status.success() {
            said(&format!("{line} within {kilobytes} kB"), &output, 1);
        }
    }
    assert!(succeeded, "some of the limits are enough");
}

/// Writes a clip of `frames` grey frames of 160x120 pixels to `path`. `luma` gives the brightness of each frame.
fn write_clip(path: &Path, frames: usize, luma: impl Fn(usize) -> u8) {
    let mut file = std::io::BufWriter::new(fs::File::create(path).unwrap());
    file.write_all(b"YUV4MPEG2 W160 H120 F30:1 C444\n").unwrap();
    for i in 0..frames {
        file.write_all(b"FRAME\n").unwrap();
        file.write_all(&[luma(i); 160 * 120]).unwrap();
        file.write_all(&[128; 2 * 160 * 120]).unwrap();
    }
    file.flush().unwrap();
}

#[cfg(target_os = "linux")]
#[test]
fn clips_are_compared_in_the_memory_of_a_few_frames() {
    let folder = tempfile::tempdir().unwrap();
    // Both clips together hold 1.2 GB of colours.
    write_clip(&folder.path().join("a.y4m"), 2000, |_| 100);
    write_clip(&folder.path().join("b.y4m"), 2000, |i| 100 + (i % 3) as u8);
    let output = within(400_000, folder.path(), "metrics a.y4m b.y4m");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(output.stdout.starts_with(b"2000 frames: PSNR "));
}

#[test]
fn frames_of_a_clip_are_compared_as_if_all_were_read_at_once() {
    use fovolnet::io::video;
    use fovolnet::metrics::{ClipQuality, ColorVideoVdp, Display, FovVideoVdp};
    let folder = tempfile::tempdir().unwrap();
    let [a, b] = ["a.y4m", "b.y4m"].map(|name| folder.path().join(name));
    write_clip(&a, 12, |i| 40 + 7 * i as u8);
    write_clip(&b, 12, |i| 41 + 7 * i as u8 + (i % 4) as u8);
    let output = run(folder.path(), "metrics a.y4m b.y4m --json -");
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    let mut clip = ClipQuality::new();
    let display = Display::named("standard_4k").unwrap();
    let mut seen = FovVideoVdp::video(&display, 30.0).unwrap();
    let mut coloured = ColorVideoVdp::video(&display, 30.0).unwrap();
    let [a, b] = [a, b].map(|path| video::read(&path).unwrap());
    for (i, (a, b)) in a.iter().zip(&b).enumerate() {
        let frame = clip.push(a, b).unwrap();
        seen.push(a, b, None).unwrap();
        coloured.push(a, b).unwrap();
        assert_eq!(report["frames"][i], serde_json::to_value(frame).unwrap(), "{i}");
    }
    let all = serde_json::to_value(clip.summary().unwrap()).unwrap();
    for key in ["psnr", "ssim", "ms_ssim", "tpsnr"] {
        assert_eq!(report[key], all[key], "{key}");
    }
    assert_eq!(report["jod"].as_f64(), seen.jod());
    assert_eq!(report["cvvdp_jod"].as_f64(), coloured.jod());
    assert_eq!(report["frames"].as_array().map(Vec::len), Some(12));
}
