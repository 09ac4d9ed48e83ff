//! The header is that of the sources.

use std::path::{Path, PathBuf};
use std::process::Command;

fn here(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

fn header() -> String {
    std::fs::read_to_string(here("include/fovolnet.h")).unwrap()
}

#[test]
fn the_header_has_every_function() {
    let header = header();
    let mut functions = 0;
    for file in std::fs::read_dir(here("src")).unwrap() {
        let source = std::fs::read_to_string(file.unwrap().path()).unwrap();
        for (before, after) in
            source.match_indices("extern \"C\" fn fovolnet_").map(|(at, _)| source.split_at(at))
        {
            let name = after["extern \"C\" fn ".len()..].split('(').next().unwrap();
            assert!(header.contains(&format!("{name}(")), "{name} is missing; make the header anew");
            let lines: Vec<&str> = before.lines().collect();
            assert!(lines.iter().rev().take(3).any(|line| line.starts_with("///")), "{name} has no comment");
            functions += 1;
        }
    }
    assert!(functions > 50, "{functions}");
}

#[test]
fn the_header_is_up_to_date() {
    let made = tempfile::tempdir().unwrap();
    let made = made.path().join("fovolnet.h");
    let mut command = Command::new("cbindgen");
    command
        .arg("--quiet")
        .arg("--config")
        .arg(here("cbindgen.toml"))
        .arg("--output")
        .arg(&made)
        .arg(here(""));
    match command.status() {
        Err(_) => eprintln!("skipped: cbindgen is not installed (cargo install cbindgen --version 0.29.4)"),
        Ok(status) => {
            assert!(status.success());
            let made = std::fs::read_to_string(made).unwrap();
            assert!(made == header(), "the header is old; bindings/c/README.md says how it is made");
        }
    }
}
