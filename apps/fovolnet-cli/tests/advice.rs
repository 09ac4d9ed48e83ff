//! Advice and behaviour in situations where a new user may be puzzled.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn run(arguments: &[&str]) -> Output {
    // An empty PATH hides ffmpeg.
    Command::new(env!("CARGO_BIN_EXE_fovolnet")).args(arguments).env("PATH", "").output().unwrap()
}

/// Standard error of a run that must succeed.
fn notes(arguments: &[&str]) -> String {
    let output = run(arguments);
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{arguments:?}: {said}");
    said
}

/// Error message of a run that must fail with `status`; notes may precede it.
fn error(arguments: &[&str], status: i32) -> String {
    let output = run(arguments);
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(status), "{arguments:?}: {said}");
    let last = said.lines().last().unwrap_or_default().to_owned();
    assert!(last.starts_with("error: "), "{said}");
    last
}

/// Temporary folder of a test.
struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn at(&self, name: &str) -> String {
        self.path(name).to_str().unwrap().to_owned()
    }

    /// Writes `bytes` to the file `name`; returns its path.
    fn file(&self, name: &str, bytes: impl AsRef<[u8]>) -> String {
        std::fs::write(self.path(name), bytes).unwrap();
        self.at(name)
    }
}

/// Renders one small frame of `volume` to `out`; returns standard error.
fn render(volume: &str, out: &str, more: &[&str]) -> String {
    notes(&[&["render", volume, "-o", out, "--size", "48x32", "--device", "cpu"], more].concat())
}

const SMALL_HEAD: [&str; 2] = ["--dims", "16,16,16"];

#[test]
fn sessions_hold_what_files_said() {
    let folder = Folder::new();
    let tf = folder.file("tf.json", r#"{"points":[[0,0,0,0,0],[0.3,1,0.4,0.1,0.05],[1,1,1,1,0.3]]}"#);
    let key = |frame: u32, x: f64| {
        format!("[[keyframe]] # one\nframe = {frame}\neye = [{x}, 0.1, 2]\ntarget = [0, 0, 0]\nfovy = 35\n")
    };
    let path = folder.file("path.toml", key(0, 0.3) + &key(5, 1.3));
    let gaze = folder.file("gaze.toml", "# where\nstops = [[0, 0.2, 0.7]]\n");
    let (before, after, session) = (folder.at("before"), folder.at("after"), folder.at("session.toml"));
    let said = ["--tf", &tf, "--path", &path, "--gaze", &gaze, "--frames", "2", "--save-session", &session];
    render("head", &before, &[&said[..], &SMALL_HEAD].concat());
    folder.file("tf.json", r#"{"points":[[0,0,0,0,0.2],[1,0,0,1,0.3]]}"#);
    folder.file("path.toml", key(0, 9.0));
    std::fs::remove_file(&gaze).unwrap();
    render(&session, &after, &[]);
    for frame in ["frame_0000.png", "frame_0001.png"] {
        let bytes = |folder: &str| std::fs::read(Path::new(folder).join(frame)).unwrap();
        assert_eq!(bytes(&before), bytes(&after), "{frame}");
    }
    let wrong = folder.file("wrong.toml", key(0, 0.3) + "up = [0, 1, 0]\n");
    let said = error(&["render", "head", "-o", &after, "--path", &wrong], 1);
    assert!(said.contains("unknown field `up`") && said.contains("line 6"), "{said}");
}

#[test]
fn sessions_are_known_by_their_names() {
    let folder = Folder::new();
    let (out, session) = (folder.at("out"), folder.at("s.json"));
    let said = error(&["render", "head", "-o", &out, "--dims", "8,8,8", "--save-session", &session], 1);
    assert!(said.contains("s.json") && said.contains("--save-session FILE.toml"), "{said}");
    assert!(!folder.path("out").exists() && !folder.path("s.json").exists());
}

#[test]
fn sessions_are_no_volumes() {
    let folder = Folder::new();
    let session = folder.file("s.toml", "volume = \"head\"\n");
    let said = error(&["info", &session], 1);
    assert!(said.contains(&format!("{session} is a session; `fovolnet render {session} -o DIR`")), "{said}");
    assert!(said.contains("`fovolnet info head`"), "{said}");
}

#[test]
fn doubtful_dims_are_noted() {
    let folder = Folder::new();
    let out = folder.at("out");
    let scan: Vec<u8> = (0..520u32).map(|i| (i % 256) as u8).collect();
    let named = folder.file("scan_8x8x8_uint8.raw", &scan[..512]);
    assert_eq!(notes(&["info", &named]), "");
    let said = notes(&["info", &named, "--dims", "8,16,4", "--dtype", "u8"]);
    assert_eq!(said, format!("note: {named}: --dims 8,16,4 contradicts the file's name, 8x8x8\n"));
    let longer = folder.file("scan.raw", &scan);
    let dims = ["--dims", "8,8,8", "--dtype", "u8"];
    let said = render(&longer, &out, &dims);
    assert!(said.contains("scan.raw has 8 bytes more than 8x8x8 u8 needs; are the dims right?"), "{said}");
    let said = error(&["info", &longer, "--dims", "9,9,9", "--dtype", "u8"], 1);
    assert!(
        said.contains("--dims 9,9,9 needs 729 bytes, the file has 520; check --dims and --dtype"),
        "{said}"
    );
}

#[test]
fn pictures_that_show_nothing_are_explained() {
    let folder = Folder::new();
    let out = folder.at("out");
    let labels: Vec<u8> = (0..4096u32).map(|i| (i % 3) as u8).collect();
    let labels = folder.file("labels_16x16x16_uint8.raw", labels);
    let tf = folder.file("tf.json", r#"{"points":[[0,0,0,0,0],[0.1,1,1,1,0],[1,1,1,1,1]]}"#);
    let cause = "values 0 to 2 are shown as 0 to 0.008 of the range; try --range 0,2";
    let said = render(&labels, &out, &["--tf", &tf]);
    assert!(said.contains(&format!("note: nothing shows; {cause}")), "{said}");
    assert!(said.contains("labels_16x16x16_uint8.raw: its 3 values look like labels"), "{said}");
    let said = render(&labels, &out, &["--tf", &tf, "--range", "0,2"]);
    assert!(!said.contains("nothing shows") && !said.contains("of the range"), "{said}");
    let away = render("head", &out, &[&["--camera", "0,0,3,0,0,9,30"], &SMALL_HEAD[..]].concat());
    assert!(
        away.contains("note: nothing shows; the camera does not see the volume: it is centred at 0"),
        "{away}"
    );
    assert!(!render("head", &out, &SMALL_HEAD).contains("nothing shows"));
}

/// JSON report of rendering the small head with the flags `more`.
fn report(folder: &Folder, more: &[&str]) -> serde_json::Value {
    let out = folder.at("out");
    let begin = ["render", "head", "-o", &out, "--size", "48x32", "--json", "-"];
    let done = run(&[&begin[..], more, &SMALL_HEAD].concat());
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    serde_json::from_slice(&done.stdout).unwrap()
}

#[test]
fn one_frame_is_marched_in_full_and_clips_are_reconstructed() {
    let folder = Folder::new();
    for (words, sampling, reconstruct) in [
        (&[][..], "full", "none"),
        (&["--frames", "2"], "compact", "wnet"),
        (&["--pb", "0.1"], "compact", "wnet"),
        (&["--gaze", "0.3,0.3"], "compact", "wnet"),
        (&["--reconstruct", "linear"], "compact", "linear"),
        (&["--reconstruct", "none"], "full", "none"),
        (&["--keep", "frame,mask"], "compact", "wnet"),
        (&["--weights", "wnet-fast"], "compact", "wnet"),
        (&["--random-weights", "deepfovea-fvn"], "compact", "deepfovea"),
        (&["--sampling", "auto", "--frames", "2"], "compact", "wnet"),
        (&["--sampling", "full", "--frames", "2"], "full", "none"),
    ] {
        let report = report(&folder, words);
        assert_eq!(
            (&report["sampling"], &report["reconstruct"]),
            (&sampling.into(), &reconstruct.into()),
            "{words:?}"
        );
    }
}

#[test]
fn flags_that_exclude_each_other_are_refused() {
    let folder = Folder::new();
    let out = folder.at("out");
    for words in [
        &["--reconstruct", "pull-push", "--weights", "wnet-fast"][..],
        &["--reconstruct", "deepfovea", "--weights", "wnet-fast"],
        &["--reconstruct", "none", "--random-weights", "wnet-fast"],
        &["--weights", "wnet-fast", "--random-weights", "wnet-fast"],
        &["--sampling", "full", "--reconstruct", "wnet"],
        &["--sampling", "full", "--weights", "wnet-fast"],
        &["--path", "orbit", "--turn", "90"],
        &["--path", "flythrough", "--view", "left"],
        &["--path", "orbit", "--camera", "0,0,3,0,0,0,35"],
    ] {
        let done = run(&[&["render", "head", "-o", &out], words, &SMALL_HEAD].concat());
        let said = String::from_utf8(done.stderr).unwrap();
        assert_eq!(done.status.code(), Some(2), "{words:?}: {said}");
        assert!(said.starts_with("error: ") && said.lines().count() == 1, "{words:?}: {said}");
        assert!(!folder.path("out").exists());
    }
    for flag in [["--turn", "90"], ["--view", "left"], ["--path", "orbit"]] {
        let still = ["render", "head", "-o", &out, "--camera", "0,0,3,0,0,0,35"];
        let said = error(&[&still[..], &flag].concat(), 2);
        assert!(said.contains(flag[0]) && said.contains("keyframes (--path FILE.toml)"), "{said}");
        assert!(said.ends_with("; see `fovolnet render --help`"), "{said}");
    }
    for words in [&["--weights", "nothing.safetensors"][..], &["--weights", "wnet-fst", "--frames", "2"]] {
        let done = run(&[&["render", "head", "-o", &out], words, &SMALL_HEAD].concat());
        assert_eq!(done.status.code(), Some(1), "{words:?}");
    }
}

#[test]
fn clips_have_names_that_say_what_they_are() {
    let folder = Folder::new();
    let clip = |name: &str| {
        let arguments =
            ["render", "head", "-o", &folder.at("out"), "--size", "48x32", "--video", &folder.at(name)];
        run(&[&arguments[..], &SMALL_HEAD].concat())
    };
    let other = String::from_utf8(clip("clip.mpeg7").stderr).unwrap();
    assert!(other.contains("clip.mpeg7") && other.contains(".y4m, .mp4, "), "{other}");
    assert!(!folder.path("out").exists());
    assert!(clip("clip.y4m").status.success());
    let kept = std::fs::read(folder.path("clip.y4m")).unwrap();
    let said = String::from_utf8(clip("clip.mp4").stderr).unwrap();
    let [made, wanted] = ["clip.mp4.y4m", "clip.mp4"].map(|name| folder.at(name));
    assert!(said.contains(&format!("the clip is {made}")), "{said}");
    assert!(said.contains(&format!("`ffmpeg -i {made} {wanted}`")), "{said}");
    assert_eq!(std::fs::read(folder.path("clip.y4m")).unwrap(), kept);
    assert!(folder.path("clip.mp4.y4m").is_file());
}

#[test]
fn one_frame_can_be_one_picture() {
    let folder = Folder::new();
    let (picture, frames) = (folder.at("new/still.png"), folder.at("frames"));
    let still = [&["--camera", "0,0,2,0,0,0,35"], &SMALL_HEAD[..]].concat();
    render("head", &picture, &still);
    render("head", &frames, &still);
    let bytes = std::fs::read(&picture).unwrap();
    assert_eq!(bytes, std::fs::read(Path::new(&frames).join("frame_0000.png")).unwrap());
    render("head", &folder.at("still.exr"), &still);
    assert!(folder.path("still.exr").is_file());
    let figures = run(&["metrics", &picture, &picture]);
    assert!(figures.status.success() && String::from_utf8_lossy(&figures.stdout).contains("PSNR 100"));
    let said = error(&["render", "head", "-o", &picture, "--frames", "3"], 1);
    assert!(said.contains("cannot hold 3 frames") && said.contains("-o DIR"), "{said}");
    assert!(error(&["render", "head", "-o", &frames, "--frames", "0"], 2).contains("--frames"));
    let session = folder.file("none.toml", "volume = \"head\"\n[render]\nframes = 0\n");
    assert!(error(&["render", &session, "-o", &frames], 1).contains("--frames 1"));
}

#[test]
fn older_frames_are_counted() {
    let folder = Folder::new();
    let out = folder.at("out");
    let rendered = |frames: &str| render("head", &out, &[&["--frames", frames], &SMALL_HEAD[..]].concat());
    assert!(!rendered("6").contains("older"));
    let said = rendered("2");
    assert!(
        said.contains(
            "also holds 4 older frames, frame_0002.png to frame_0005.png, which were left in place"
        ),
        "{said}"
    );
    assert_eq!(std::fs::read_dir(&out).unwrap().count(), 6);
}

#[test]
fn names_are_listed_and_slips_recognised() {
    let folder = Folder::new();
    let out = folder.at("out");
    let listed = run(&["info", "--transfer-functions"]);
    let listed = String::from_utf8(listed.stdout).unwrap();
    assert!(listed.contains("auto") && listed.contains("viridis magma"), "{listed}");
    let head = ["render", "head", "-o", &out];
    for (arguments, status, meant) in [
        (&["render", "haed", "-o", &out][..], 1, "did you mean head?"),
        (&[&head[..], &["--tf", "virdis"]].concat(), 1, "did you mean viridis?"),
        (&[&head[..], &["--reconstruct", "wnett"]].concat(), 2, "did you mean wnet?"),
        (&[&head[..], &["--reconstruct", "wnet-fast"]].concat(), 2, "--reconstruct wnet --weights wnet-fast"),
        (
            &[&head[..], &["--reconstruct", "wnet", "--weights", "wnet-fst"]].concat(),
            1,
            "did you mean wnet-fast?",
        ),
        (&["demo", "--volume", "plum"][..], 2, "did you mean plume?"),
        (&["repro", "masks", "--volume", "haed:48"][..], 1, "did you mean head?"),
    ] {
        let said = error(arguments, status);
        assert!(said.contains(meant), "{arguments:?}: {said}");
    }
    render("head", &out, &[&["--tf", "Viridis"], &SMALL_HEAD[..]].concat());
}

#[test]
fn messages_say_what_helps() {
    let folder = Folder::new();
    let nothing = run(&[]);
    let said = String::from_utf8(nothing.stderr).unwrap();
    assert!(
        nothing.status.code() == Some(2) && said.contains("Commands:") && !said.contains("error"),
        "{said}"
    );
    std::fs::create_dir(folder.path("series")).unwrap();
    let slice = [&[0; 128][..], b"DICM"].concat();
    folder.file("series/IM1", &slice);
    let one = folder.file("one.dcm", slice);
    for dicom in [folder.at("series"), one] {
        assert!(error(&["info", &dicom], 1).contains("it is no DICOM file; check how"), "{dicom}");
    }
    let session = folder.file("s.toml", "volume = \"head\"\n[render]\nsgima = 3\n");
    let said = error(&["render", &session, "-o", &folder.at("out")], 1);
    assert!(said.contains("`sgima`") && said.contains("`sigma`"), "{said}");
    let tf = folder.file("hounsfield.json", r#"{"points":[[-1000,0,0,0,0],[3000,1,1,1,1]]}"#);
    let said = error(&["render", "head", "-o", &folder.at("out"), "--tf", &tf], 1);
    assert!(said.contains("v runs from 0 to 1 over the shown range"), "{said}");
    assert!(said.contains(r#"for data values add "range":[LO,HI] beside "points""#), "{said}");
    let header = b"NRRD0004\ntype: uint8\ndimension: 4\nsizes: 2 2 1 3\nencoding: raw\n\n";
    let moving = folder.file("moving.nrrd", [&header[..], &[0, 255, 3, 4, 5, 6, 7, 8, 9, 1, 2, 3]].concat());
    let told = run(&["info", &moving]);
    assert!(String::from_utf8_lossy(&told.stdout).contains("times       3"), "{told:?}");
    let said = String::from_utf8_lossy(&told.stderr);
    assert!(said.contains("3 time points, number 0 is shown; --time N chooses another"), "{told:?}");
    let said = render(&moving, &folder.at("out"), &[]);
    assert!(said.contains("moving.nrrd has 3 time points, number 0 is shown"), "{said}");
}
