//! Small runs of `fovolnet repro`.

use std::path::Path;
use std::process::{Command, Output};

fn repro(arguments: &[&str], folder: &Path) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_fovolnet"));
    command.arg("repro").args(arguments).args(["--volume", "vortices:24", "--volume", "head:24"]);
    command.args(["--size", "96x96", "--frames", "4", "-o"]).arg(folder).output().expect("the program runs")
}

fn text(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

#[test]
fn everything_is_made_and_bound_into_one_page() {
    let folder = tempfile::tempdir().unwrap();
    let done = repro(&["all"], folder.path());
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let page = text(&folder.path().join("report.html"));
    let names = "data-sets noise masks frame-times speedups quality over-time jod precision compression \
                 ablations alternatives scaling video";
    for name in names.split(' ') {
        assert!(page.contains(&format!("<section id=\"{name}\">")), "{name}");
        let facts: serde_json::Value =
            serde_json::from_str(&text(&folder.path().join(name).join("section.json"))).unwrap();
        assert_eq!(facts["name"], name);
        for table in facts["tables"].as_array().unwrap() {
            let csv =
                text(&folder.path().join(name).join(format!("{}.csv", table["name"].as_str().unwrap())));
            assert_eq!(csv.lines().count(), 1 + table["rows"].as_array().unwrap().len(), "{name}");
        }
    }
    let film =
        |name: &str| ["mp4", "y4m"].map(|kind| folder.path().join(format!("video/{name}.{kind}")).exists());
    assert!(film("head").contains(&true) && film("vortices").contains(&true));
    // The report must not load anything from the network.
    assert!(!page.contains("http://") && !page.contains("https://"));
    let speedups = text(&folder.path().join("speedups/speedups.csv"));
    let overall: Vec<&str> = speedups.lines().last().unwrap().split(',').collect();
    assert_eq!((overall[0], overall.len()), ("overall", 10));
    assert!(overall[1..].iter().all(|number| number.parse::<f64>().unwrap() > 0.0), "{speedups}");
}

#[test]
fn what_was_made_before_stays_in_the_report() {
    let folder = tempfile::tempdir().unwrap();
    for item in ["masks", "data-sets"] {
        assert!(repro(&[item], folder.path()).status.success());
    }
    let page = text(&folder.path().join("report.html"));
    let [table, figure] =
        ["data-sets", "masks"].map(|name| page.find(&format!("<section id=\"{name}\">")).unwrap());
    assert!(table < figure && page.contains("24×24×24"));
}

#[test]
fn wrong_words_are_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let wrong = [["nothing", "head"], ["masks", "no-such-volume"], ["masks", "head"]];
    for ([item, volume], code) in wrong.into_iter().zip([2, 1, 1]) {
        let done = Command::new(env!("CARGO_BIN_EXE_fovolnet"))
            .args(["repro", item, "--volume", volume, "--volume", "head:16", "-o"])
            .arg(folder.path().join("never"))
            .output()
            .unwrap();
        let said = String::from_utf8_lossy(&done.stderr).into_owned();
        assert_eq!(done.status.code(), Some(code), "{said}");
        assert!(said.starts_with("error: ") && said.lines().count() == 1, "{said}");
    }
    assert!(!folder.path().join("never").exists());
}

/// Name of the first adapter.
fn adapter() -> String {
    let devices = ["info", "--devices", "--json", "-"];
    let done = Command::new(env!("CARGO_BIN_EXE_fovolnet")).args(devices).output().unwrap();
    let facts: serde_json::Value = serde_json::from_slice(&done.stdout).unwrap();
    facts["gpus"][0]["name"].as_str().expect("an adapter").to_owned()
}

#[test]
#[ignore = "needs a graphics processor, or Mesa's software one"]
fn times_are_those_of_every_device() {
    let folder = tempfile::tempdir().unwrap();
    let adapter = adapter();
    let done = Command::new(env!("CARGO_BIN_EXE_fovolnet"))
        .env("FOVOLNET_GPU", &adapter)
        .args(["repro", "speedups", "frame-times", "--volume", "head:16", "--size", "48x32", "--frames", "2"])
        .arg("-o")
        .arg(folder.path())
        .output()
        .unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    for file in
        ["speedups/speedups", "speedups/speedups_cpu", "frame-times/summary", "frame-times/summary_cpu"]
    {
        assert!(text(&folder.path().join(file).with_extension("csv")).lines().count() >= 3, "{file}");
    }
    assert!(text(&folder.path().join("report.html")).contains(&format!("ms a frame on {adapter}")));
}
