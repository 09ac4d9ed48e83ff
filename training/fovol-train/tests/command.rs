//! Tests of the compiled program.

use std::process::{Command, Stdio};

#[test]
fn what_nobody_reads_ends_nothing() {
    let mut command = Command::new(env!("CARGO_BIN_EXE_fovolnet-train"));
    let mut running =
        command.arg("check").stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("it starts");
    drop(running.stdout.take());
    let ended = running.wait_with_output().unwrap();
    assert!(ended.status.success(), "{}", String::from_utf8_lossy(&ended.stderr));
}
