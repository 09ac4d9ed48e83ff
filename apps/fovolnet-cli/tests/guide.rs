//! Runs the commands of the guide: every block of the language `sh,run`, line by line, in one folder for each chapter.

mod command;

use command::succeeds;
use std::fs;
use std::path::{Path, PathBuf};

/// Opening fence of a block to run.
const FENCE: &str = "```sh,run\n";

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn chapters() -> Vec<PathBuf> {
    let folder = root().join("docs/guide/src");
    let mut files: Vec<PathBuf> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.retain(|path| path.extension().is_some_and(|ending| ending == "md"));
    files.sort();
    files
}

/// Lines of all blocks of `text` that are to be run.
fn commands(text: &str) -> Vec<&str> {
    let blocks = text.split(FENCE).skip(1).map(|rest| rest.split("```").next().unwrap_or_default());
    blocks.flat_map(str::lines).filter(|line| !line.trim().is_empty()).collect()
}

#[test]
fn commands_of_the_guide_run() {
    let mut count = 0;
    for chapter in chapters() {
        let folder = tempfile::tempdir().unwrap();
        let text = fs::read_to_string(&chapter).unwrap();
        for line in commands(&text) {
            let arguments =
                line.strip_prefix("fovolnet ").unwrap_or_else(|| panic!("{}: {line}", chapter.display()));
            succeeds(folder.path(), arguments);
            count += 1;
        }
    }
    assert!(count >= 10, "{count}");
}

#[test]
fn the_summary_lists_every_chapter() {
    let summary = fs::read_to_string(root().join("docs/guide/src/SUMMARY.md")).unwrap();
    for chapter in chapters() {
        let name = chapter.file_name().unwrap().to_str().unwrap();
        assert!(name == "SUMMARY.md" || summary.contains(&format!("({name})")), "{name}");
    }
}
