//! `bench march --model`, which needs no GPU, and `bench gpu`, which does.

mod command;

use command::{fails, run, succeeds};
use serde_json::Value;
use std::path::Path;

const HEAD: &str = "bench march head --dims 24,24,24 --size 64x48";

fn read(path: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap()
}

#[test]
fn the_model_tells_what_every_strategy_costs() {
    let folder = tempfile::tempdir().unwrap();
    let report = run(folder.path(), &format!("{HEAD} --model --json -"));
    let report: Value = serde_json::from_slice(&report.stdout).unwrap();
    assert_eq!(report["gpu"], "h200");
    let rows = report["strategies"].as_array().unwrap();
    let named = |name: &str| rows.iter().find(|row| row["name"] == name).unwrap();
    let chain = |name: &str| named(name)["longest_chain"].as_u64().unwrap();
    assert!(chain("pool:4,128") * 4 < chain("rays"), "{report}");
    for row in rows.iter().chain(report["sparse"]["strategies"].as_array().unwrap()) {
        let number = |key: &str| row[key].as_f64().unwrap();
        assert!(
            number("warp_steps") > 0.0 && number("ms") > 0.0 && number("loads_per_shadow_step") >= 2.0,
            "{row}"
        );
        assert!((0.0..=1.0).contains(&number("busy_lanes")), "{row}");
    }
    let other = run(folder.path(), &format!("{HEAD} --model RTX-4090 --json -"));
    assert_eq!(serde_json::from_slice::<Value>(&other.stdout).unwrap()["gpu"], "rtx-4090");
    let unknown = fails(folder.path(), &format!("{HEAD} --model h20"), 1);
    assert!(unknown.contains("did you mean h200?"), "{unknown}");
}

#[test]
fn a_benchmark_without_a_gpu_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let error = fails(folder.path(), "bench gpu -o gpu.json --device cpu", 1);
    assert!(error.contains("--device gpu"), "{error}");
    let error = fails(folder.path(), "bench gpu -o gpu.json --minutes 0", 1);
    assert!(error.contains("above 0"), "{error}");
}

#[test]
#[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
fn a_benchmark_of_a_gpu_goes_on_where_it_ended() {
    let folder = tempfile::tempdir().unwrap();
    succeeds(folder.path(), "bench gpu --quick -o gpu.json --device gpu");
    let whole = read(&folder.path().join("gpu.json"));
    let rows = whole["rows"].as_array().unwrap();
    let equal = rows.iter().filter(|row| row["equal"] == true).count();
    assert!(
        equal >= 15 && rows.iter().all(|row| row["equal"] != false && row["measured"].as_f64() > Some(0.0)),
        "{whole}"
    );
    // Without the last rows, they alone are measured again.
    let mut part = whole.clone();
    part["rows"].as_array_mut().unwrap().truncate(rows.len() - 1);
    std::fs::write(folder.path().join("gpu.json"), part.to_string()).unwrap();
    succeeds(folder.path(), "bench gpu --quick --resume -o gpu.json --device gpu");
    let resumed = read(&folder.path().join("gpu.json"));
    let kept = rows.len() - 1;
    assert_eq!(resumed["rows"].as_array().unwrap()[..kept], rows[..kept]);
    assert_eq!(resumed["rows"].as_array().unwrap().len(), rows.len());
    std::fs::write(folder.path().join("gpu.json"), r#"{"adapter": "another", "rows": []}"#).unwrap();
    let error = fails(folder.path(), "bench gpu --quick --resume -o gpu.json --device gpu", 1);
    assert!(error.contains("write another file"), "{error}");
}
