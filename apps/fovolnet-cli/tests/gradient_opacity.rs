//! Opacity by gradient from the command line.

mod command;

use command::{fails, run, succeeds};
use std::path::Path;

const SMALL: &str = "--dims 24,24,24 --size 32x24 --device cpu --sampling full";

fn write(folder: &Path, name: &str, gradient: &str) {
    let points = r#""points":[[0,0,0,0,0],[1,1,1,1,0.3]]"#;
    std::fs::write(folder.join(name), format!("{{{points}{gradient}}}")).unwrap();
}

#[test]
fn files_may_have_it_and_sessions_keep_it() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), "whole.json", "");
    write(folder.path(), "borders.json", r#","gradient":[[0.01,0],[0.05,1]]"#);
    succeeds(folder.path(), &format!("render head -o whole.png --tf whole.json {SMALL}"));
    let output = run(
        folder.path(),
        &format!("render head -o borders.png --tf borders.json --save-session s.toml {SMALL}"),
    );
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success() && said.contains("note: opacity by gradient is integrated as"), "{said}");
    std::fs::remove_file(folder.path().join("borders.json")).unwrap();
    succeeds(folder.path(), "render s.toml -o again.png --device cpu");
    let bytes = |name: &str| std::fs::read(folder.path().join(name)).unwrap();
    assert_eq!(bytes("borders.png"), bytes("again.png"));
    assert_ne!(bytes("borders.png"), bytes("whole.png"));
}

#[test]
fn bad_points_are_one_line_of_error() {
    let folder = tempfile::tempdir().unwrap();
    for (gradient, meant) in [
        (r#","gradient":[]"#, "no points"),
        (r#","gradient":[[0,0],[0.1,2]]"#, "factor 2 at point 1"),
        (r#","gradient":[[0.1,0],[0,1]]"#, "sort the points by gradient"),
        (r#","gradient":[[0,0,1]]"#, "[gradient, factor]"),
    ] {
        write(folder.path(), "bad.json", gradient);
        let said = fails(folder.path(), &format!("render head -o x.png --tf bad.json {SMALL}"), 1);
        assert!(said.contains(meant) && said.contains("bad.json"), "{said}");
    }
}
