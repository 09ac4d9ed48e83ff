//! Test of the command without a window.
#![cfg(target_os = "linux")]

use std::process::Command;

#[test]
fn without_a_display_it_says_how_to_get_one() {
    let mut command = Command::new(env!("CARGO_BIN_EXE_fovolnet-viewer"));
    for name in ["DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET"] {
        command.env_remove(name);
    }
    let output = command.args(["head", "--dims", "8,8,8"]).output().unwrap();
    let error = String::from_utf8(output.stderr).unwrap();
    assert_eq!((output.status.code(), error.lines().count()), (Some(1), 1), "{error}");
    assert!(error.starts_with("error: no window can be opened") && error.contains("xvfb-run -a"), "{error}");
    assert!(!error.contains(".rs"), "{error}");
}
