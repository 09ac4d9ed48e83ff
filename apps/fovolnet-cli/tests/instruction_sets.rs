//! `--simd` and `FOVOLNET_SIMD`: one instruction set for marcher and networks.

use fovolnet::simd::Simd;
use serde_json::Value;
use std::process::{Command, Output};

/// Runs `fovolnet` with `arguments`, and with the variable FOVOLNET_SIMD if it is given.
fn fovolnet(variable: Option<&str>, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_fovolnet"));
    command.args(arguments).env_remove("FOVOLNET_SIMD");
    if let Some(set) = variable {
        command.env("FOVOLNET_SIMD", set);
    }
    command.output().unwrap()
}

fn json(output: &Output) -> Value {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

#[test]
fn marcher_and_networks_take_the_set_of_the_flag_or_of_the_variable() {
    let march =
        ["bench", "march", "head", "--dims", "8,8,8", "--size", "16x16", "--repeats", "1", "--json", "-"];
    let net =
        ["bench", "net", "--random-weights", "wnet-fast", "--size", "64x64", "--repeats", "1", "--json", "-"];
    for set in Simd::choices() {
        let set = set.name();
        let of_march = if set == "amx" { "avx512" } else { set };
        let by_flag =
            |arguments: &[&str]| json(&fovolnet(Some("portable"), &[arguments, &["--simd", set]].concat()));
        let by_variable = |arguments: &[&str]| json(&fovolnet(Some(set), arguments));
        for report in [by_flag(&march), by_variable(&march)] {
            let rows = report["rows"].as_array().unwrap();
            assert!(!rows.is_empty() && rows.iter().all(|row| row["simd"] == of_march), "{report}");
        }
        for report in [by_flag(&net), by_variable(&net)] {
            let on = report["on"].as_str().unwrap();
            assert!(on.starts_with(set) || (set == "scalar" && on.starts_with("portable")), "{set}: {on}");
        }
    }
    assert_eq!(json(&fovolnet(Some(""), &net))["on"], json(&fovolnet(None, &net))["on"]);
}

#[test]
fn pictures_do_not_depend_on_how_vectors_gather() {
    let folder = tempfile::tempdir().unwrap();
    let picture = |gathers: &str, set: Simd| {
        let file = folder.path().join(format!("{gathers}.png"));
        let (file, set) = (file.to_str().unwrap(), set.name());
        let frame = ["bench", "march", "head", "--dims", "24,24,24", "--size", "48x48", "--repeats", "1"];
        let output = Command::new(env!("CARGO_BIN_EXE_fovolnet"))
            .args(frame)
            .args(["--simd", set, "--picture", file])
            .env("FOVOLNET_GATHERS", gathers)
            .output()
            .unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        std::fs::read(file).unwrap()
    };
    for set in Simd::available() {
        assert_eq!(picture("loads", set), picture("hardware", set), "{set}");
    }
}

#[test]
fn a_variable_that_names_no_set_is_said() {
    let output = fovolnet(Some("mmx"), &["info", "head"]);
    let error = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(
        error.starts_with("error: FOVOLNET_SIMD: `mmx` is no instruction set") && error.lines().count() == 1
    );
}
