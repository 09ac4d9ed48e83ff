//! No temporary file and no child process outlives `abandon`. The test is alone in this file, since `abandon` ends the
//! work of its whole process.
#![cfg(unix)]

use fovol_core::ChildProcess;
use fovol_core::unfinished::{self, Gate};
use std::fs;
use std::process::Command;
use std::time::Duration;

#[test]
#[expect(clippy::disallowed_methods, reason = "this is what whoever renames files relies on")]
fn nothing_unfinished_is_left_and_nothing_new_is_made() {
    let folder = tempfile::tempdir().unwrap();
    let [renamed, left] = ["renamed", "left"].map(|name| folder.path().join(name));
    for file in [&renamed, &left] {
        let gate = Gate::enter();
        fs::write(file, "half").unwrap();
        gate.add_file(file);
    }
    let gate = Gate::enter();
    fs::rename(&renamed, folder.path().join("final")).unwrap();
    drop(gate);
    unfinished::forget_file(&renamed);
    // The child makes the file again and again.
    let again = format!("while :; do : > '{}'; sleep 0.01; done", left.display());
    let mut child = ChildProcess::start(Command::new("sh").args(["-c", &again])).unwrap();

    let gate = unfinished::abandon(Duration::from_secs(10)).unwrap();
    assert!(!left.exists());
    assert_eq!(child.wait().unwrap().code(), None, "it was not killed");
    let late = std::thread::spawn(|| drop(Gate::enter()));
    std::thread::sleep(Duration::from_millis(100));
    assert!(!late.is_finished(), "another thread entered the gate");
    assert!(unfinished::abandon(Duration::from_millis(50)).is_none());
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    drop(gate);
    late.join().unwrap();
}
