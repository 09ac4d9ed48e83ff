//! Kills commands at random moments. Every file under its final name must be whole. After signals that can be caught,
//! nothing else may be left, and the command must end quickly.
//!
//! `FOVOLNET_KILLS` sets the number of kills (default 60), `FOVOLNET_KILLS_SEED` the random seed.
#![cfg(unix)]

mod command;

use command::{files, run, succeeds};
use std::ffi::OsStr;
use std::fs;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

/// Signals that end a command. KILL cannot be caught.
const SIGNALS: [(&str, i32); 4] =
    [("INT", libc::SIGINT), ("TERM", libc::SIGTERM), ("HUP", libc::SIGHUP), ("KILL", libc::SIGKILL)];

/// Longest time for a command to end: a second, with a margin for busy machines.
const LIMIT: Duration = Duration::from_secs(3);

/// Number of frames in every clip.
const FRAMES: usize = 4;

/// Commands that write files, from the inputs in the folder of [`inputs`]. `{}` is the output folder.
const KINDS: [&str; 29] = [
    "render v.nrrd -o {}/p.png --size 96x64 --reconstruct pull-push",
    "render v.nrrd -o {}/p.exr --size 96x64 --shadows cached",
    "render v.nrrd -o {}/d --size 96x64 --frames 4 --keep frame,sparse,mask,motion,reference",
    "render v.nrrd -o {}/d --size 96x64 --frames 4 --format exr --reconstruct pull-push",
    "render v.nrrd -o {}/d --size 96x64 --frames 4 --reconstruct pull-push --video {}/c.y4m",
    "render v.nrrd -o {}/d --size 96x64 --frames 4 --reconstruct pull-push --video {}/c.mp4",
    "render v.nrrd -o {}/d --size 96x64 --frames 4 --reconstruct pull-push --video {}/c.gif",
    "render v.nrrd -o {}/d --size 96x64 --frames 2 --save-session {}/s.toml --json {}/r.json",
    "convert v.nrrd {}/v.raw",
    "convert v.nrrd {}/v_64x64x64_uint8.raw",
    "convert v.nrrd {}/v.raw.gz",
    "convert v.nrrd {}/v.nrrd",
    "convert v.nrrd {}/v.nhdr",
    "convert v.nrrd {}/v.nii",
    "convert v.nrrd {}/v.nii.gz",
    "convert v.nrrd {}/v.mha",
    "convert v.nrrd {}/v.mhd",
    "convert v.nrrd {}/v.vti",
    "data make engine {}/v.nrrd --dims 64,64,64",
    "data make angiogram {}/a.nhdr --dims 64,64,64",
    "data make vortices {}/v.nii.gz --dims 64,64,64",
    "noise make {}/n.npy --size 32 --frames 16",
    "reconstruct frames -o {}/f",
    "metrics frames frames --json {}/m.json",
    "info v.nrrd --json {}/i.json",
    "mask -o {}/mask.png --size 256x256 --json {}/mask.json",
    "bench march v.nrrd --size 64x48 --repeats 2 --json {}/b.json",
    "demo --dims 16,16,16 --size 64x48 --frames 2 -o {}/demo",
    "export --random-weights wnet-narrow --onnx {}/net.onnx",
];

/// Folder with the inputs of the commands.
fn inputs() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    succeeds(folder.path(), "data make head v.nrrd --dims 64,64,64");
    succeeds(folder.path(), "render v.nrrd -o frames --size 96x64 --frames 4 --keep frame,sparse");
    folder
}

/// Random numbers from a seed.
struct Draws(u64);

impl Draws {
    /// Random number in 0…`count` − 1.
    fn below(&mut self, count: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as usize % count
    }
}

/// Number in the environment variable `name`.
fn setting(name: &str) -> Option<u64> {
    std::env::var(name).ok().map(|text| text.parse().unwrap_or_else(|_| panic!("{name} is no number")))
}

fn start(folder: &Path, line: &str) -> Child {
    let mut command = Command::new(env!("CARGO_BIN_EXE_fovolnet"));
    command.args(line.split_whitespace().map(OsStr::new)).current_dir(folder);
    // Tests that run under `nohup` pass on that HUP is ignored.
    // SAFETY: `signal` may be called between fork and exec.
    unsafe {
        command.pre_exec(|| {
            libc::signal(libc::SIGHUP, libc::SIG_DFL);
            Ok(())
        });
    }
    command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
}

fn send(child: &Child, signal: i32) {
    // SAFETY: the child is ours and not waited for, so its number is not reused.
    unsafe { libc::kill(child.id() as libc::pid_t, signal) };
}

/// Exit status of `child` if it ends within `limit`; otherwise kills it and returns `None`.
fn ended(child: &mut Child, limit: Duration) -> Option<ExitStatus> {
    let started = Instant::now();
    loop {
        match child.try_wait().unwrap() {
            Some(status) => return Some(status),
            None if started.elapsed() > limit => {
                child.kill().unwrap();
                child.wait().unwrap();
                return None;
            }
            None => std::thread::sleep(Duration::from_millis(2)),
        }
    }
}

fn is_temporary(file: &Path) -> bool {
    file.file_name().unwrap().to_string_lossy().starts_with('.')
}

/// Sizes in bytes of files without a header: volumes with one and two bytes per voxel, and ranks.
const BYTES: [(&str, u64); 3] =
    [("a.raw", 64 * 64 * 64), ("v.raw", 2 * 64 * 64 * 64), ("n.npy", 128 + 4 * 32 * 32 * 16)];

/// Why the file at `path` is not whole, judged by the program itself; `None` if it is.
fn problem(folder: &Path, path: &Path) -> Option<String> {
    let name = path.file_name().unwrap().to_str().unwrap();
    let shown = path.to_str().unwrap();
    let length = fs::metadata(path).unwrap().len();
    // These files have no header, or a kill prevented it, so only the size tells.
    if let Some((_, whole)) = BYTES.iter().find(|(known, _)| *known == name) {
        return (length != *whole).then(|| format!("{length} bytes"));
    }
    let line = match path.extension().and_then(OsStr::to_str).unwrap_or_default() {
        "gz" if name == "v.raw.gz" => format!("info {shown} --dims 64,64,64 --dtype u16"),
        "raw" | "gz" | "nrrd" | "nhdr" | "nii" | "mha" | "mhd" | "vti" => format!("info {shown}"),
        "y4m" | "mp4" | "gif" => return clip_problem(folder, shown),
        "png" | "exr" => format!("metrics {shown} {shown}"),
        "toml" => format!("render {shown} -o checked.png --frames 1 --size 16x16 --reconstruct pull-push"),
        "json" => {
            let read = serde_json::from_slice::<serde_json::Value>(&fs::read(path).unwrap());
            return read.err().map(|error| error.to_string());
        }
        _ => return (length == 0).then(|| "nothing in it".into()),
    };
    let output = run(folder, &line);
    (!output.status.success()).then(|| String::from_utf8_lossy(&output.stderr).into_owned())
}

fn clip_problem(folder: &Path, clip: &str) -> Option<String> {
    let output = run(folder, &format!("metrics {clip} {clip} --json -"));
    let report: Option<serde_json::Value> = serde_json::from_slice(&output.stdout).ok();
    let frames = report.and_then(|report| report["frames"].as_array().map(Vec::len));
    let expected = if clip.contains("demo") { 2 } else { FRAMES };
    (frames != Some(expected))
        .then(|| format!("{frames:?} frames; {}", String::from_utf8_lossy(&output.stderr)))
}

/// Whether another process, such as ffmpeg, works on a file in `folder`.
fn is_worked_on(folder: &Path) -> bool {
    let folder = folder.to_str().unwrap();
    let processes = fs::read_dir("/proc").into_iter().flatten().flatten();
    processes.into_iter().any(|process| {
        let line = fs::read(process.path().join("cmdline")).unwrap_or_default();
        String::from_utf8_lossy(&line).contains(folder)
    })
}

#[test]
fn commands_that_are_killed_leave_whole_files_and_nothing_else() {
    let has_ffmpeg = Command::new("ffmpeg").arg("-version").output().is_ok();
    let inputs = inputs();
    let mut draws = Draws(setting("FOVOLNET_KILLS_SEED").unwrap_or(1));
    let mut lasts = [None; KINDS.len()];
    for _ in 0..setting("FOVOLNET_KILLS").unwrap_or(60) {
        let kind = draws.below(KINDS.len());
        if !has_ffmpeg && [".mp4", ".gif"].iter().any(|clip| KINDS[kind].contains(clip)) {
            continue;
        }
        let (name, signal) = SIGNALS[draws.below(SIGNALS.len())];
        let lasts = *lasts[kind].get_or_insert_with(|| {
            let out = tempfile::tempdir().unwrap();
            let started = Instant::now();
            succeeds(inputs.path(), &KINDS[kind].replace("{}", out.path().to_str().unwrap()));
            started.elapsed()
        });
        let out = tempfile::tempdir().unwrap();
        let line = KINDS[kind].replace("{}", out.path().to_str().unwrap());
        let mut child = start(inputs.path(), &line);
        let moment = lasts.mul_f64(draws.below(1000) as f64 / 1000.0);
        std::thread::sleep(moment);
        send(&child, signal);
        let status = ended(&mut child, LIMIT);
        let what = format!("{line}: {name} after {moment:?} of {lasts:?}: {status:?}");
        // Before the command listens, a signal ends it like any program.
        assert!(status.is_some_and(|status| matches!(status.code(), None | Some(0 | 1))), "{what}");
        let is_killed = signal == libc::SIGKILL;
        if !is_killed {
            assert!(!is_worked_on(out.path()), "{what}: a program goes on");
        }
        for file in files(out.path()) {
            match is_temporary(&file) {
                true => assert!(is_killed, "{what}: {} is left", file.display()),
                false => assert_eq!(problem(inputs.path(), &file), None, "{what}: {}", file.display()),
            }
        }
    }
}

#[test]
fn long_work_ends_at_once_and_says_so() {
    let inputs = inputs();
    let out = inputs.path().join("out");
    for line in [
        "noise make {}/n.npy --size 256 --frames 256",
        "data make angiogram {}/a.nrrd --dims 512,512,512",
        "data make vortices {}/v.nrrd --dims 256,256,256",
        "render head -o {}/p.png --dims 400,400,400 --shadows cached",
        "render v.nrrd -o {}/p.png --size 8000x6000 --sampling full",
        "bench march v.nrrd --size 4000x3000 --repeats 99",
    ] {
        for (name, signal) in &SIGNALS[..3] {
            let line = line.replace("{}", out.to_str().unwrap());
            fs::create_dir_all(&out).unwrap();
            let mut child = start(inputs.path(), &line);
            std::thread::sleep(Duration::from_millis(800));
            send(&child, *signal);
            let status = ended(&mut child, LIMIT);
            assert_eq!(status.and_then(|status| status.code()), Some(1), "{line}: {name}: {status:?}");
            assert_eq!(files(&out), Vec::<PathBuf>::new(), "{line}: {name}");
        }
    }
}

#[test]
fn hup_stays_ignored_where_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let line = format!(
        "trap '' HUP; exec {} noise make n.npy --size 64 --frames 32",
        env!("CARGO_BIN_EXE_fovolnet")
    );
    let mut shell = Command::new("sh");
    let mut child =
        shell.args(["-c", &line]).current_dir(folder.path()).stdout(Stdio::null()).spawn().unwrap();
    for _ in 0..3 {
        std::thread::sleep(Duration::from_millis(100));
        send(&child, libc::SIGHUP);
    }
    let status = ended(&mut child, Duration::from_secs(120)).expect("it ends");
    assert!(status.success() && folder.path().join("n.npy").is_file(), "{status}");
}
