//! `reconstruct` and `metrics` on frames of other renderers.

use fovolnet::core::{Frame, FrameSize};
use fovolnet::io::image::{self, Alpha};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn fovolnet(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_fovolnet")).args(arguments).output().unwrap()
}

/// Standard output and error of a run that must succeed.
fn succeeds(arguments: &[&str]) -> (String, String) {
    let output = fovolnet(arguments);
    let [out, error] = [output.stdout, output.stderr].map(|said| String::from_utf8(said).unwrap());
    assert!(output.status.success(), "{arguments:?}: {error}");
    (out, error)
}

/// JSON that a run writes to standard output.
fn json(arguments: &[&str]) -> Value {
    serde_json::from_str(&succeeds(arguments).0).unwrap()
}

/// Error message of a run that must fail with `status`: one line.
fn fails(arguments: &[&str], status: i32) -> String {
    let output = fovolnet(arguments);
    let error = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(status), "{arguments:?}: {error}");
    let errors: Vec<&str> = error
        .lines()
        .filter(|line| !line.starts_with("note: ") && !line.starts_with("reconstructing "))
        .collect();
    assert!(errors.len() == 1 && errors[0].starts_with("error: "), "{error}");
    error
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

const SIZE: FrameSize = FrameSize { width: 48, height: 32 };

/// Disc that moves right by 1.5 pixels per frame, with one of seven pixels sampled.
fn sparse(i: u32, size: FrameSize) -> Frame {
    let mut frame = Frame::new(size);
    for (k, pixel) in frame.pixels_mut().iter_mut().enumerate() {
        let (x, y) = ((k as u32 % size.width) as f32, (k as u32 / size.width) as f32);
        let is_inside = (x - 14.0 - 1.5 * i as f32).hypot(y - 16.0) < 9.0;
        if (k + 3 * i as usize).is_multiple_of(7) {
            *pixel = if is_inside { [0.9, 0.5, 0.1, 1.0] } else { [0.0, 0.0, 0.2, 1.0] };
        }
    }
    frame
}

/// Folder of `frames` sparse frames with the names that `name` returns.
fn folder(frames: u32, name: impl Fn(u32) -> String) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for i in 0..frames {
        image::write_png(&folder.path().join(name(i)), &sparse(i, SIZE), Alpha::Keep).unwrap();
    }
    folder
}

fn padded(i: u32) -> String {
    format!("sparse_{i:04}.png")
}

fn bytes(path: impl AsRef<Path>) -> Vec<u8> {
    std::fs::read(path.as_ref()).unwrap_or_else(|e| panic!("{}: {e}", path.as_ref().display()))
}

#[test]
fn the_network_is_the_default_and_weights_name_it() {
    let sparse = folder(2, padded);
    let out = tempfile::tempdir().unwrap();
    let made = |name: &str, flags: &[&str]| {
        let to = out.path().join(name);
        let report = succeeds(
            &[&["reconstruct", text(sparse.path()), "-o", text(&to), "--json", "-"], flags].concat(),
        );
        let report: Value = serde_json::from_str(&report.0).unwrap();
        (report["reconstruct"].as_str().unwrap().to_owned(), bytes(to.join("frame_0001.png")))
    };
    let exact = ["--precision", "f32", "--device", "cpu"];
    let default = made("default", &exact);
    assert_eq!(default.0, "wnet");
    assert_eq!(default, made("named", &[&exact[..], &["--reconstruct", "wnet"]].concat()));
    assert_eq!(default, made("weights", &[&exact[..], &["--weights", "wnet-fast"]].concat()));
    let filled = made("filled", &["--reconstruct", "pull-push"]);
    assert!(filled.0 == "pull-push" && filled.1 != default.1);
    let random = made("random", &["--random-weights", "deepfovea-fvn", "--device", "cpu"]);
    assert!(random.0 == "deepfovea" && random.1 != filled.1);
    let wrong = |flags: &[&str], status| {
        fails(&[&["reconstruct", text(sparse.path()), "-o", text(out.path())], flags].concat(), status)
    };
    assert!(
        wrong(&["--reconstruct", "pull-push", "--weights", "wnet-fast"], 2).contains("--reconstruct wnet")
    );
    assert!(wrong(&["--reconstruct", "none"], 2).contains("pull-push"));
    for how in [&[][..], &["--reconstruct", "pull-push"], &["--reconstruct", "wnet"]] {
        let error = wrong(&[&["--weights", "/no/such/weights.safetensors"], how].concat(), 1);
        assert!(error.contains("/no/such/weights.safetensors"), "{error}");
    }
}

#[test]
fn frames_stand_in_the_order_of_their_numbers() {
    let (zeros, plain) = (folder(12, padded), folder(12, |i| format!("sparse_{i}.png")));
    let out = tempfile::tempdir().unwrap();
    let flags = ["--precision", "f32", "--device", "cpu"];
    let [a, b] = [("a", &zeros), ("b", &plain)].map(|(name, from)| {
        let to = out.path().join(name);
        succeeds(&[&["reconstruct", text(from.path()), "-o", text(&to)], &flags[..]].concat());
        to
    });
    for i in 0..12 {
        assert_eq!(
            bytes(a.join(format!("frame_{i:04}.png"))),
            bytes(b.join(format!("frame_{i}.png"))),
            "{i}"
        );
    }
    // `metrics` also matches padded and unpadded numbers.
    let (report, _) = succeeds(&["metrics", text(&a), text(&b), "--json", "-"]);
    let report: Value = serde_json::from_str(&report).unwrap();
    assert_eq!(report["psnr"], 100.0);
}

#[test]
fn frames_that_are_no_sparse_clip_are_said_so() {
    let out = tempfile::tempdir().unwrap();
    let to = text(out.path());
    let flags = ["-o", to, "--reconstruct", "pull-push"];
    let run = |from: &Path| [&["reconstruct", text(from)], &flags[..]].concat().join("\u{1}");
    let refused = |from: &Path| fails(&run(from).split('\u{1}').collect::<Vec<_>>(), 1);
    let accepted = |from: &Path| succeeds(&run(from).split('\u{1}').collect::<Vec<_>>()).1;

    let opaque = folder(1, padded);
    image::write_png(&opaque.path().join("sparse_0001.png"), &sparse(1, SIZE), Alpha::Drop).unwrap();
    let error = refused(opaque.path());
    assert!(error.contains("sparse_0001.png") && error.contains("alpha"), "{error}");

    let sizes = folder(1, padded);
    let other = FrameSize { width: 50, height: 32 };
    image::write_png(&sizes.path().join("sparse_0001.png"), &sparse(1, other), Alpha::Keep).unwrap();
    let error = refused(sizes.path());
    assert!(error.contains("50x32") && error.contains("48x32"), "{error}");

    let twice = folder(2, |i| ["sparse_1.png", "sparse_0001.png"][i as usize].into());
    assert!(refused(twice.path()).contains("same frame"));

    let gaps = folder(3, |i| format!("sparse_{:04}.png", 2 * i));
    let said = accepted(gaps.path());
    assert!(said.contains("frames 1, 3 are missing"), "{said}");

    let full = tempfile::tempdir().unwrap();
    let mut frame = Frame::new(SIZE);
    frame.pixels_mut().fill([0.5, 0.5, 2.0, 1.0]);
    image::write_exr(&full.path().join("sparse_0000.exr"), &frame).unwrap();
    let said = accepted(full.path());
    assert!(said.contains("every pixel is sampled") && said.contains("linear light"), "{said}");
}

#[test]
fn motion_of_another_size_is_refused_and_missing_motion_said() {
    let clip = folder(2, padded);
    let out = tempfile::tempdir().unwrap();
    let arguments = ["reconstruct", text(clip.path()), "-o", text(out.path()), "--device", "cpu"];
    image::write_exr(&clip.path().join("motion_0.exr"), &Frame::new(SIZE)).unwrap();
    let (_, said) = succeeds(&arguments);
    assert!(said.contains("sparse_0001.png: no motion"), "{said}");
    let (_, said) = succeeds(&[&arguments[..], &["--reconstruct", "pull-push"]].concat());
    assert!(said.contains("motion is not used by pull-push"), "{said}");
    let small = FrameSize { width: 24, height: 16 };
    image::write_exr(&clip.path().join("motion_1.exr"), &Frame::new(small)).unwrap();
    assert!(fails(&arguments, 1).contains("24x16"));
}

#[test]
fn exr_windows_and_channels_of_others_are_read() {
    let cases = std::env::var_os("FOVOL_TEST_DATA").map_or("../../../shared/data".into(), PathBuf::from);
    let cases = Path::new(env!("CARGO_MANIFEST_DIR")).join(cases).join("cases/58-exr");
    if !cases.is_dir() {
        println!("skipped: no {}", cases.display());
        return;
    }
    let window = image::read_picture(&cases.join("window/sparse_0000.exr")).unwrap();
    assert_eq!(window.frame.size(), FrameSize { width: 80, height: 64 });
    // The data window is columns 10 to 69 and rows 8 to 47.
    assert!(window.has_alpha && window.frame.pixel(9, 20)[3] == 0.0 && window.frame.pixel(70, 20)[3] == 0.0);
    assert!((10..70).any(|x| window.frame.pixel(x, 8)[3] == 1.0));
    let motion = image::read_motion(&cases.join("two/motion_0001.exr")).unwrap();
    assert!(motion.ways.iter().all(|way| *way == [1.5, 0.0]));
    let out = tempfile::tempdir().unwrap();
    succeeds(&["reconstruct", text(&cases.join("window")), "-o", text(out.path()), "--device", "cpu"]);
    assert_eq!(image::size(&out.path().join("frame_0001.exr")).unwrap().width, 80);
}

#[test]
fn equal_frames_are_equal_files() {
    let folder = tempfile::tempdir().unwrap();
    let size = FrameSize { width: 640, height: 400 };
    let path = folder.path().join("a.exr");
    let first = {
        image::write_exr(&path, &sparse(0, size)).unwrap();
        bytes(path.clone())
    };
    for _ in 0..12 {
        image::write_exr(&path, &sparse(0, size)).unwrap();
        assert!(bytes(path.clone()) == first);
    }
}

#[test]
fn terminals_are_safe_from_names_of_files() {
    let folder = tempfile::tempdir().unwrap();
    let inside = folder.path().join("a\x1b[31mb\u{9b}c");
    std::fs::create_dir(&inside).unwrap();
    let error = fails(&["reconstruct", text(&inside), "-o", text(folder.path())], 1);
    assert!(!error.contains('\x1b') && error.contains("\\u{1b}[31m"), "{error}");
    let out = inside.join("out");
    let clip = self::folder(3, |i| format!("sparse_{}.png", 2 * i));
    let (said, notes) =
        succeeds(&["reconstruct", text(clip.path()), "-o", text(&out), "--reconstruct", "pull-push"]);
    assert!(!said.contains('\x1b') && said.contains("\\u{1b}[31m") && notes.contains("gaps"), "{said}");
    let error =
        fails(&["render", "head", "--dims", "8,8,8", "-o", text(folder.path()), "--tf", "\x1b[2J"], 1);
    assert!(!error.contains('\x1b'), "{error}");
}

#[cfg(unix)]
#[test]
fn a_limit_of_files_is_an_error_that_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let size = FrameSize { width: 640, height: 400 };
    image::write_exr(&folder.path().join("sparse_0000.exr"), &sparse(0, size)).unwrap();
    let out = folder.path().join("out");
    // The limit counts blocks of 512 bytes.
    let script = "ulimit -f 8; exec \"$0\" reconstruct \"$1\" -o \"$2\" --reconstruct pull-push --device cpu";
    let run = Command::new("sh")
        .args(["-c", script, env!("CARGO_BIN_EXE_fovolnet"), text(folder.path()), text(&out)])
        .output()
        .unwrap();
    let error = String::from_utf8(run.stderr).unwrap();
    assert_eq!(run.status.code(), Some(1), "{error}");
    assert!(error.lines().any(|line| line.starts_with("error: cannot write")), "{error}");
    assert_eq!(std::fs::read_dir(&out).unwrap().count(), 0);
}

/// Frames with a guide are filled as `render` fills them.
#[test]
fn light_ratios_of_others_are_filled_as_render_does() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (rendered, again) = (at("rendered"), at("again"));
    let background = ["--background", "0.1,0.2,0.4"];
    let mut render = vec!["render", "head", "-o", &rendered, "--frames", "3", "--device", "cpu"];
    render.extend(["--keep", "frame,sparse,motion,guide", "--format", "exr", "--dims", "32,32,32"]);
    render.extend(["--size", "96x72", "--pb", "0.1", "--precision", "f32", "--guide", "quarter"]);
    let report = json(&[&render[..], &background, &["--json", "-"]].concat());
    assert_eq!(report["guide"], "quarter");
    assert!(report["frames"][1]["guide_samples"].as_u64().unwrap() > 300, "{report}");
    assert!(report["mean"]["ms"]["guide"].as_f64().unwrap() > 0.0, "{report}");
    let fill = ["reconstruct", &rendered, "-o", &again, "--precision", "f32", "--device", "cpu"];
    succeeds(&[&fill[..], &background].concat());
    let figures = json(&["metrics", &rendered, &again, "--json", "-"]);
    // `render` works on the visible part alone.
    assert!(figures["psnr"].as_f64().unwrap() > 45.0, "{figures}");
    let ratio = image::read(&folder.path().join("rendered/ratio_0002.exr")).unwrap();
    assert!(ratio.pixels().iter().flatten().all(|v| (0.0..=1.0).contains(v)));
    std::fs::remove_file(folder.path().join("rendered/guide_0001.exr")).unwrap();
    let error = fails(&fill, 1);
    assert!(error.contains("sparse_0001.exr has no guide"), "{error}");
}

/// Frames without anything visible have an empty guide. Where there is no guide at all, nothing is written.
#[test]
fn guides_of_nothing_are_empty_and_none_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("away");
    let out_text = out.to_str().unwrap();
    let common =
        ["render", "head", "--dims", "16,16,16", "--size", "32x24", "--device", "cpu", "-o", out_text];
    let away = ["--keep", "guide", "--guide", "quarter", "--camera", "0,0,3,0,0,9,35"];
    succeeds(&[&common[..], &away].concat());
    let [guide, ratio] =
        ["guide_0000.exr", "ratio_0000.exr"].map(|name| image::read(&out.join(name)).unwrap());
    assert!(guide.pixels().iter().all(|p| *p == [0.0; 4]));
    assert!(ratio.pixels().iter().all(|p| *p == [1.0; 4]));
    let none = folder.path().join("none");
    let error =
        fails(&[&common[..9], &[none.to_str().unwrap(), "--keep", "guide", "--shadows", "off"]].concat(), 1);
    assert!(error.contains("there is no guide") && !none.exists(), "{error}");
}
