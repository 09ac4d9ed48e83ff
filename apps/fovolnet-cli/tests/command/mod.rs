//! Runs the command and checks its messages, for several test files.
#![allow(dead_code, reason = "each test uses a part")]

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

/// Runs the command `line` in `folder`; arguments are separated by spaces.
pub fn run(folder: &Path, line: &str) -> Output {
    command(folder, line).output().unwrap()
}

fn command(folder: &Path, line: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_fovolnet"));
    command.args(line.split_whitespace().map(OsStr::new)).current_dir(folder).stdin(Stdio::null());
    command
}

/// Runs `line`, which must succeed.
pub fn succeeds(folder: &Path, line: &str) {
    let output = run(folder, line);
    assert!(output.status.success(), "{line}: {}", String::from_utf8_lossy(&output.stderr));
}

/// Runs `line`, which must fail with `status` and a single line of error, without a panic. Returns that line.
pub fn fails(folder: &Path, line: &str, status: i32) -> String {
    said(line, &run(folder, line), status)
}

/// Error line of `output` from a command that must have failed with `status`.
pub fn said(line: &str, output: &Output, status: i32) -> String {
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(status), "{line}: {error}");
    let errors: Vec<&str> = error.lines().filter(|line| line.starts_with("error: ")).collect();
    assert!(errors.len() == 1 && !error.contains("panicked"), "{line}: {error}");
    errors[0].to_owned()
}

/// All files below `folder`.
pub fn files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() { found.extend(files(&path)) } else { found.push(path) }
    }
    found
}

/// Output of `line` if it ends within `limit`; otherwise kills it and returns `None`.
pub fn within(limit: Duration, folder: &Path, line: &str) -> Option<Output> {
    let mut child = command(folder, line).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let started = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if started.elapsed() > limit {
            child.kill().unwrap();
            child.wait().unwrap();
            return None;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    Some(child.wait_with_output().unwrap())
}
