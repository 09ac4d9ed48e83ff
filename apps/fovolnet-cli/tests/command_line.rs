//! The command line as users run it.

use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output, Stdio};

fn fovolnet(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_fovolnet")).args(arguments).output().unwrap()
}

/// Standard output of a run that must succeed.
fn succeeds(arguments: &[&str]) -> String {
    let output = fovolnet(arguments);
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// Error message of a run that must fail with `status`: one line, no panic.
fn fails(arguments: &[&str], status: i32) -> String {
    let output = fovolnet(arguments);
    let error = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(status), "{arguments:?}: {error}");
    let lines: Vec<&str> = error.lines().collect();
    assert_eq!(lines.len(), 1, "{arguments:?}: {error}");
    assert!(lines[0].starts_with("error: "), "{error}");
    assert!(!error.contains("panicked"), "{error}");
    error
}

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|e| panic!("{e}: {text}"))
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn a_reader_that_has_enough_is_no_failure() {
    for arguments in [&["--help"][..], &["info", "head", "--dims", "8,8,8"], &["convert", "--help"]] {
        let mut command = Command::new(env!("CARGO_BIN_EXE_fovolnet"));
        let mut child =
            command.args(arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop(child.stdout.take());
        let output = child.wait_with_output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success() && said.is_empty(), "{arguments:?}: {said}");
    }
}

#[test]
fn volumes_are_seen_more_coarsely() {
    let folder = tempfile::tempdir().unwrap();
    let small = folder.path().join("small.nrrd");
    let small = small.to_str().unwrap();
    succeeds(&["convert", "engine", small, "--dims", "9,8,6", "--downsample", "2"]);
    let info = json(&succeeds(&["info", small, "--json", "-"]));
    assert_eq!(info["dims"], serde_json::json!([5, 4, 3]));
    let same = ["info", "engine", "--dims", "9,8,6", "--downsample", "2", "--json", "-"];
    assert_eq!(json(&succeeds(&same))["min"], info["min"]);
    assert!(fails(&["info", "engine", "--downsample", "0"], 1).contains("expected 1 or more"));
}

const SMALL: [&str; 4] = ["--size", "96x64", "--dims", "32,32,32"];

#[test]
fn render_writes_what_is_kept_and_reports_it() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let mut arguments =
        vec!["render", "marschner-lobb", "-o", out.to_str().unwrap(), "--frames", "2", "--json", "-"];
    arguments.extend(["--keep", "frame,sparse,mask,reference"]);
    arguments.extend(SMALL);
    let report = json(&succeeds(&arguments));
    assert_eq!(report["size"], serde_json::json!([96, 64]));
    let frames = report["frames"].as_array().unwrap();
    assert_eq!(frames.len(), 2);
    for frame in frames {
        let density = frame["density"].as_f64().unwrap();
        assert_eq!(frame["samples"].as_u64().unwrap(), (density * 96.0 * 64.0).round() as u64);
        for key in ["mask", "march", "reconstruct", "total"] {
            assert!(frame["ms"][key].is_number(), "{key}");
        }
        assert!(frame["psnr"].as_f64().unwrap() > 15.0);
        assert!(frame["ssim"].as_f64().unwrap() > 0.2);
    }
    let expected: Vec<String> = ["frame", "mask", "reference", "sparse"]
        .iter()
        .flat_map(|name| (0..2).map(move |i| format!("{name}_{i:04}.png")))
        .collect();
    assert_eq!(names(&out), expected);
}

#[test]
fn references_have_exact_shadows() {
    let folder = tempfile::tempdir().unwrap();
    let render = |shadows: &str, keep: &str| {
        let out = folder.path().join(shadows);
        let mut arguments = vec!["render", "head", "-o", out.to_str().unwrap(), "--sampling", "compact"];
        arguments.extend(["--format", "exr", "--shadows", shadows, "--keep", keep, "--json", "-"]);
        arguments.extend(SMALL);
        let report = json(&succeeds(&arguments));
        let pictures =
            ["frame", "reference"].map(|name| std::fs::read(out.join(format!("{name}_0000.exr"))).ok());
        (report["mean"].clone(), pictures)
    };
    let (mean, [frame, reference]) = render("cached", "frame,reference");
    let [off, on] = ["off", "on"].map(|shadows| render(shadows, "frame,reference").1);
    assert!(reference.is_some() && reference == on[1] && reference != off[1]);
    assert!(frame != on[0], "frames have the shadows that were asked for");
    // With cached shadows in the reference, as in the full frame, quality would look better than it is.
    let out = folder.path().join("full");
    let full = ["render", "head", "-o", out.to_str().unwrap(), "--sampling", "full", "--format", "exr"];
    succeeds(&[&full[..], &["--shadows", "cached"], &SMALL].concat());
    let [full, sparse] = ["full", "cached"].map(|name| folder.path().join(name).join("frame_0000.exr"));
    let against = ["metrics", full.to_str().unwrap(), sparse.to_str().unwrap(), "--json", "-"];
    let cached = json(&succeeds(&against))["psnr"].as_f64().unwrap();
    let exact = mean["psnr"].as_f64().unwrap();
    assert!(exact < cached - 0.01, "{exact} {cached}");
}

/// All files that `render` with `flags` writes, by name.
fn rendered(flags: &str, threads: &str) -> Vec<(String, Vec<u8>)> {
    let folder = tempfile::tempdir().unwrap();
    let mut arguments = vec!["render", "head", "-o", folder.path().to_str().unwrap(), "--threads", threads];
    arguments.extend(SMALL);
    arguments.extend(flags.split_whitespace());
    succeeds(&arguments);
    let names = std::fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().path());
    let files = names
        .map(|path| (path.file_name().unwrap().to_str().unwrap().to_owned(), std::fs::read(path).unwrap()));
    let mut files: Vec<_> = files.collect();
    files.sort();
    files
}

#[test]
fn the_same_command_gives_the_same_bytes_on_any_number_of_threads() {
    let mut settings = vec![
        "--sampling full".to_owned(),
        "--sampling full --transparent --shadows cached --shading gradient".to_owned(),
        "--reconstruct wnet --precision int8 --keep frame,reference,motion".to_owned(),
        "--sampling full --integration plain --shadows off".to_owned(),
    ];
    for sampling in ["reject", "direct", "compact"] {
        for reconstruct in ["none", "linear", "pull-push", "wnet"] {
            settings.push(format!(
                "--sampling {sampling} --reconstruct {reconstruct} --keep frame,sparse,mask,motion"
            ));
        }
    }
    for (i, setting) in settings.iter().enumerate() {
        let format = if i % 4 == 0 { "png" } else { "exr" };
        let flags = format!("{setting} --format {format}");
        let once = rendered(&flags, "1");
        assert!(once.iter().any(|(name, _)| name == &format!("frame_0000.{format}")), "{flags}");
        for threads in ["3", "2"] {
            assert!(once == rendered(&flags, threads), "{flags}");
        }
    }
}

#[test]
fn a_session_replays_to_the_same_pixels() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let mut arguments = vec!["render", "engine"];
    let (a, b, session) = (path("a"), path("b"), path("session.toml"));
    arguments.extend([
        "-o",
        &a,
        "--save-session",
        &session,
        "--pb",
        "0.2",
        "--gaze",
        "0.3,0.6",
        "--seed",
        "3",
    ]);
    arguments.extend([
        "--noise",
        "uniform",
        "--light",
        "-1,1,0",
        "--shadows",
        "cached",
        "--first-frame",
        "7",
    ]);
    arguments.extend(SMALL);
    succeeds(&arguments);
    succeeds(&["render", &session, "-o", &b]);
    let frame = |folder: &str| std::fs::read(Path::new(folder).join("frame_0007.png")).unwrap();
    assert_eq!(frame(&a), frame(&b));
}

#[test]
fn transparent_pictures_have_alpha_and_replay() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (a, b, exr, session) = (path("a"), path("b"), path("exr"), path("session.toml"));
    let full = ["--sampling", "full", "--transparent"];
    let whole = [&["render", "head", "-o", &a, "--save-session", &session], &full[..], &SMALL].concat();
    succeeds(&whole);
    succeeds(&["render", &session, "-o", &b]);
    let bytes = |folder: &str| std::fs::read(Path::new(folder).join("frame_0000.png")).unwrap();
    assert_eq!(bytes(&a), bytes(&b));
    // Byte 25 of a PNG is the colour type of its header; 6 is RGBA.
    assert_eq!(bytes(&a)[25], 6);
    succeeds(&["render", &session, "-o", &exr, "--format", "exr"]);
    let read = |file: &str| fovolnet::io::image::read(&folder.path().join(file)).unwrap();
    let (straight, premultiplied) = (read("a/frame_0000.png"), read("exr/frame_0000.exr"));
    assert_eq!(straight.pixel(0, 0), [0.0; 4]);
    assert!(straight.pixels().iter().any(|p| p[3] > 0.9));
    for (s, p) in straight.premultiplied().pixels().iter().zip(premultiplied.pixels()) {
        assert!((0..4).all(|c| (s[c] - p[c]).abs() < 1.5 / 255.0), "{s:?} {p:?}");
    }
    succeeds(&["render", &session, "-o", &b, "--transparent=false"]);
    assert_eq!(bytes(&b)[25], 2);
    let clip = path("clip.y4m");
    assert!(fails(&["render", &session, "-o", &b, "--video", &clip], 1).contains("--video"));
    let sparse = [&["render", "head", "-o", &b, "--transparent", "--pb", "0.1"], &SMALL[..]].concat();
    assert!(fails(&sparse, 1).contains("--sampling full"));
}

#[test]
fn sparse_frames_are_reconstructed_as_render_does() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (rendered, again) = (path("rendered"), path("again"));
    let mut arguments = vec!["render", "plume", "-o", &rendered, "--keep", "sparse,frame", "--format", "exr"];
    arguments.extend(SMALL);
    arguments.extend(["--reconstruct", "pull-push"]);
    succeeds(&arguments);
    succeeds(&["reconstruct", &rendered, "-o", &again, "--reconstruct", "pull-push"]);
    let figures = json(&succeeds(&["metrics", &rendered, &again, "--json", "-"]));
    assert_eq!(figures["psnr"], 100.0);
    assert!(figures["frames"][0]["tpsnr"].is_null());
}

#[test]
fn networks_reconstruct_clips_and_are_exported() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let mut render = vec!["render", "head", "--frames", "3", "--keep", "frame,sparse,motion"];
    render.extend(SMALL);
    // Pictures of samples have no guide.
    render.extend(["--guide", "none"]);
    let network = ["--reconstruct", "wnet", "--random-weights", "wnet-fast:3", "--precision", "f32"];
    let (first, second) = (at("first"), at("second"));
    succeeds(&[&render[..], &["-o", &first], &network].concat());
    // The network fills the same frames from their sparse pictures, which have only 8 bits.
    succeeds(&[&["reconstruct", &first, "-o", &second], &network[..]].concat());
    let report = json(&succeeds(&["metrics", &first, &second, "--json", "-"]));
    assert!(report["psnr"].as_f64().unwrap() > 40.0, "{report}");
    let onnx = at("network.onnx");
    succeeds(&["export", "--onnx", &onnx, "--random-weights", "wnet-fast"]);
    assert!(std::fs::metadata(&onnx).unwrap().len() > 100_000);

    let out = at("out");
    succeeds(&[&render[..], &["-o", &out, "--reconstruct", "deepfovea"]].concat());
    // Without `--weights` it uses the built-in weights.
    let (shipped, named) = (at("shipped"), at("named"));
    succeeds(&[&render[..], &["-o", &shipped, "--reconstruct", "wnet"]].concat());
    succeeds(&[&render[..], &["-o", &named, "--reconstruct", "wnet", "--weights", "wnet-fast"]].concat());
    let report = json(&succeeds(&["metrics", &shipped, &named, "--json", "-"]));
    assert!(report["psnr"].is_null() || report["psnr"].as_f64().unwrap() > 90.0, "{report}");
    succeeds(&[&render[..], &["-o", &out, "--reconstruct", "wnet", "--weights", "wnet-paper"]].concat());
    let narrow = ["-o", &out, "--reconstruct", "wnet", "--weights", "wnet-narrow"];
    let error = fails(&[&render[..], &narrow].concat(), 1);
    assert!(error.contains("wnet-fast, wnet-paper, deepfovea-fvn"), "{error}");
    let other = ["-o", &out, "--reconstruct", "deepfovea", "--random-weights", "wnet-fast"];
    assert!(fails(&[&render[..], &other].concat(), 2).contains("--reconstruct wnet"));
    std::fs::write(at("bad.safetensors"), b"nothing").unwrap();
    let bad = at("bad.safetensors");
    let error = fails(&[&render[..], &["-o", &out, "--reconstruct", "wnet", "--weights", &bad]].concat(), 1);
    assert!(error.contains("bad.safetensors") && error.contains("safetensors file"), "{error}");
    fails(&[&render[..], &["-o", &out, "--random-weights", "wnet-none"]].concat(), 2);
}

#[test]
fn the_mask_has_the_density_of_the_paper() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("mask.png");
    let report = json(&succeeds(&["mask", "-o", out.to_str().unwrap(), "--json", "-"]));
    assert!((report["expected_density"].as_f64().unwrap() - 0.0343).abs() < 5e-5);
    assert!((report["density"].as_f64().unwrap() / 0.0343 - 1.0).abs() < 0.02);
    assert!(out.is_file());
}

#[test]
fn clips_are_written_and_compared() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (out, clip) = (path("out"), path("clip.y4m"));
    let mut arguments = vec!["render", "marschner-lobb", "-o", &out, "--frames", "3", "--video", &clip];
    arguments.extend(SMALL);
    succeeds(&arguments);
    let figures = json(&succeeds(&["metrics", &out, &clip, "--json", "-"]));
    assert_eq!(figures["frames"].as_array().unwrap().len(), 3);
    assert!(figures["psnr"].as_f64().unwrap() > 40.0);
}

#[test]
fn clips_are_judged_by_eyes_before_a_display() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (full, sparse) = (path("full"), path("sparse"));
    for (out, how) in [(&full, ["--sampling", "full"]), (&sparse, ["--reconstruct", "pull-push"])] {
        succeeds(&[&["render", "head", "-o", out, "--frames", "3"], &how[..], &SMALL[..]].concat());
    }
    let jod = |test: &str, options: &[&str]| {
        let report = json(&succeeds(&[&["metrics", &full, test, "--json", "-"], options].concat()));
        report["jod"].as_f64().unwrap()
    };
    let coloured = |test: &str, options: &[&str]| {
        let report = json(&succeeds(&[&["metrics", &full, test, "--json", "-"], options].concat()));
        report["cvvdp_jod"].as_f64().unwrap()
    };
    assert_eq!(coloured(&full, &[]), 10.0);
    let seen = coloured(&sparse, &[]);
    assert!(seen > 0.0 && seen < 9.9, "{seen}");
    assert_ne!(coloured(&sparse, &["--fps", "60"]), seen);
    assert_ne!(coloured(&sparse, &["--display", "standard_hmd"]), seen);
    assert_eq!(coloured(&sparse, &["--fixation", "0.5,0.5"]), seen);
    assert_eq!(jod(&full, &[]), 10.0);
    let plain = jod(&sparse, &[]);
    assert!(plain > 0.0 && plain < 9.9, "{plain}");
    assert_eq!(jod(&sparse, &["--fps", "30", "--display", "standard_4k"]), plain);
    assert_ne!(jod(&sparse, &["--fps", "60"]), plain);
    assert_ne!(jod(&sparse, &["--display", "standard_hmd"]), plain);
    let fractions = jod(&sparse, &["--fixation", "0.5,0.5"]);
    assert_eq!(jod(&sparse, &["--fixation", "47.5,31.5"]), fractions);
    assert!(fractions > plain);
    let printed = succeeds(&["metrics", &full, &sparse]);
    assert!(printed.contains(&format!("JOD {plain:.4}, ColorVideoVDP {seen:.4} JOD")), "{printed}");
    let wrong = |options: &[&str], status| fails(&[&["metrics", &full, &sparse], options].concat(), status);
    let error = wrong(&["--display", "television"], 2);
    assert!(error.contains("television") && error.contains("standard_fhd"), "{error}");
    assert!(wrong(&["--fps", "0"], 1).contains("frame rate"));
    assert!(wrong(&["--fixation", "0.5"], 2).contains("--fixation"));
}

#[test]
fn pictures_are_judged_without_time_and_tiny_ones_not_at_all() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    for (size, judged) in [("64x48", true), ("3x3", false)] {
        let (a, b) = (path(&format!("a{size}")), path(&format!("b{size}")));
        for (out, pb) in [(&a, "0.9"), (&b, "0.1")] {
            let shape = ["--size", size, "--dims", "16,16,16", "--reconstruct", "pull-push", "--pb", pb];
            succeeds(&[&["render", "marschner-lobb", "-o", out], &shape[..]].concat());
        }
        for key in ["jod", "cvvdp_jod"] {
            let jod =
                |fps: &str| json(&succeeds(&["metrics", &a, &b, "--json", "-", "--fps", fps]))[key].clone();
            assert_eq!(jod("30").is_number(), judged);
            assert_eq!(jod("30"), jod("90"));
        }
    }
}

#[test]
fn noise_is_made_and_checked() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("noise.npy");
    let out = out.to_str().unwrap();
    succeeds(&["noise", "make", out, "--size", "32", "--frames", "8"]);
    let report = fovolnet(&["noise", "check", out, "--json", "-"]);
    let report = json(std::str::from_utf8(&report.stdout).unwrap());
    assert!(
        report["checks"].as_array().unwrap().iter().any(|c| c["name"].as_str().unwrap().contains("spatial"))
    );
}

#[test]
fn bad_input_is_one_clear_line() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let out = path("out");
    assert!(fails(&["info", "/no/such/volume.raw"], 1).contains("/no/such/volume.raw"));
    std::fs::write(path("short_64x64x64_uint8.raw"), b"few").unwrap();
    assert!(fails(&["info", &path("short_64x64x64_uint8.raw")], 1).contains("262144"));
    std::fs::write(path("empty.raw"), b"").unwrap();
    fails(&["info", &path("empty.raw")], 1);
    for (flag, value) in [
        ("--size", "0x64"),
        ("--size", "100000x64"),
        ("--pb", "nan"),
        ("--step", "inf"),
        ("--light", "nan,0,0"),
        ("--gaze", "x"),
        ("--reconstruct", "magic"),
        ("--simd", "avx9000"),
        ("--no-such-flag", "1"),
    ] {
        let output = fovolnet(&["render", "head", "-o", &out, "--dims", "8,8,8", flag, value]);
        let error = String::from_utf8(output.stderr).unwrap();
        assert!(matches!(output.status.code(), Some(1 | 2)), "{flag} {value}: {error}");
        assert_eq!(error.lines().count(), 1, "{flag} {value}: {error}");
    }
    for (flag, value) in [
        ("--tf", "no-such-preset"),
        ("--pb", "2"),
        ("--sigma", "-1"),
        ("--step", "0"),
        ("--light", "0,0,0"),
        ("--path", "/none.toml"),
        ("--ambient", "7"),
    ] {
        fails(&["render", "head", "-o", &out, "--dims", "8,8,8", "--size", "8x8", flag, value], 1);
    }
    assert!(!Path::new(&out).exists() || names(Path::new(&out)).is_empty());
}

#[cfg(unix)]
#[test]
fn a_full_disk_is_said_so_and_leaves_nothing() {
    if !Path::new("/dev/full").exists() {
        println!("skipped: this system has no /dev/full");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("not-a-folder");
    std::fs::write(&out, b"a file is in the way").unwrap();
    fails(&["render", "head", "-o", out.to_str().unwrap(), "--dims", "8,8,8", "--size", "8x8"], 1);
    assert_eq!(std::fs::read(&out).unwrap(), b"a file is in the way");
}

#[test]
fn training_is_started_or_its_building_explained() {
    let help = fovolnet(&["train", "--help"]);
    let said = String::from_utf8_lossy(&help.stdout).into_owned() + &String::from_utf8_lossy(&help.stderr);
    assert!(said.contains("CONFIG.toml") || said.contains("cargo build --release --manifest-path"), "{said}");
}

#[test]
fn devices_are_listed_and_chosen() {
    let devices = json(&succeeds(&["info", "--devices", "--json", "-"]));
    for gpu in devices["gpus"].as_array().unwrap() {
        assert!(gpu["name"].is_string() && gpu["automatic"].is_boolean(), "{gpu}");
    }
    let folder = tempfile::tempdir().unwrap();
    let on = |device: &'static str| {
        let arguments =
            ["render", "marschner-lobb", "-o", folder.path().to_str().unwrap(), "--device", device];
        [&arguments[..], &SMALL].concat()
    };
    succeeds(&on("cpu"));
    let silent = fovolnet(&on("auto"));
    assert!(silent.status.success() && !String::from_utf8_lossy(&silent.stderr).contains("error"));
    assert!(fails(&on("cuda"), 2).contains("use auto, cpu, gpu, or gpu:NAME"));
    let missing = fails(&on("gpu:no such device"), 1);
    assert!(missing.contains("--device cpu"), "{missing}");
}

#[cfg(feature = "gpu")]
#[test]
#[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
fn frames_of_others_are_filled_alike_on_either_device() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let sparse = path("sparse");
    let moving = ["--path", "flythrough", "--pb", "0.1", "--keep", "sparse,motion", "--frames", "3"];
    succeeds(
        &[&["render", "head", "-o", &sparse, "--dims", "32,32,32", "--size", "48x32"], &moving[..]].concat(),
    );
    for how in ["pull-push", "wnet"] {
        let filled = ["cpu", "gpu"].map(|device| {
            let out = path(&format!("{how}-{device}"));
            succeeds(&["reconstruct", &sparse, "-o", &out, "--reconstruct", how, "--device", device]);
            out
        });
        let report = json(&succeeds(&["metrics", &filled[0], &filled[1], "--json", "-"]));
        assert!(report["psnr"].as_f64().unwrap() > 50.0, "{how}: {report}");
    }
    // The CPU does what the GPU does not support, with a note.
    let linear = fovolnet(&[
        "reconstruct",
        &sparse,
        "-o",
        &path("linear"),
        "--reconstruct",
        "linear",
        "--device",
        "gpu",
    ]);
    let said = String::from_utf8(linear.stderr).unwrap();
    assert!(linear.status.success() && said.contains("linear is filled on the processor"), "{said}");
}
