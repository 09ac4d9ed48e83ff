//! Frames within a budget, as a user renders them.

mod command;

use command::{fails, succeeds};
use std::fs;
use std::path::Path;

const HEAD: &str = "head --dims 48,48,48 --size 96x64 --device cpu";

/// The frames of the report `file`.
fn frames(folder: &Path, file: &str) -> Vec<serde_json::Value> {
    let text = fs::read_to_string(folder.join(file)).unwrap();
    let report: serde_json::Value = serde_json::from_str(&text).unwrap();
    report["frames"].as_array().unwrap().clone()
}

fn pictures(folder: &Path, count: usize) -> Vec<Vec<u8>> {
    (0..count).map(|i| fs::read(folder.join(format!("frame_{i:04}.png"))).unwrap()).collect()
}

#[test]
fn plans_are_told_measured_and_repeated() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    // Smaller frames have too few pixels to measure errors at: their predictions are off by 5 dB on some machines.
    let head = "head --dims 48,48,48 --size 192x128 --device cpu";
    let flags = "--frames 10 --budget 8 --keep frame,reference --json plan.json --save-session plan.toml";
    succeeds(folder.path(), &format!("render {head} -o first {flags}"));
    let made = frames(folder.path(), "plan.json");
    let mut distances = Vec::new();
    let mut within = 0;
    for frame in &made {
        let plan = &frame["plan"];
        assert!(plan["way"].is_string() && plan["why"].is_string() && plan["step"].is_number(), "{plan}");
        assert!(plan["predicted_ms"].as_f64().unwrap() > 0.0, "{plan}");
        let [least, most] = [0, 1].map(|end| plan["psnr_range"][end].as_f64().unwrap());
        let psnr = plan["psnr"].as_f64().unwrap();
        assert!(least <= psnr && psnr <= most, "{plan}");
        let truth = frame["psnr"].as_f64().unwrap();
        distances.push((psnr - truth).abs());
        within += usize::from((least - 1.0..=most + 1.0).contains(&truth));
        let [width, height] = [0, 1].map(|side| plan["size"][side].as_f64().unwrap());
        if ["exact light", "cached light"].contains(&plan["way"].as_str().unwrap()) {
            let density = width * height / (192.0 * 128.0);
            assert!((frame["density"].as_f64().unwrap() - density).abs() < 1e-9, "{frame}");
        }
    }
    distances.sort_by(f64::total_cmp);
    assert!(distances[5] < 3.0, "{distances:?}");
    assert!(within >= 8, "{made:?}");
    let saved = fs::read_to_string(at("plan.toml")).unwrap();
    assert!(saved.contains("[[plan]]") && saved.contains("budget = 8.0"), "{saved}");
    succeeds(folder.path(), "render plan.toml --device cpu -o again --json again.json");
    assert_eq!(pictures(&at("first"), 10), pictures(&at("again"), 10));
    let why = |frame: &serde_json::Value| frame["plan"]["why"] == "as the session says";
    assert!(frames(folder.path(), "again.json").iter().all(why));
}

#[test]
fn without_a_budget_equal_flags_give_equal_frames() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["a", "b"] {
        let flags = format!("--frames 4 --quality auto --json {name}.json");
        succeeds(folder.path(), &format!("render {HEAD} -o {name} {flags}"));
    }
    assert_eq!(pictures(&folder.path().join("a"), 4), pictures(&folder.path().join("b"), 4));
    let plans = |name: &str| -> Vec<serde_json::Value> {
        frames(folder.path(), name).iter().map(|frame| frame["plan"].clone()).collect()
    };
    assert_eq!(plans("a.json"), plans("b.json"));
}

#[test]
fn what_is_given_is_kept_and_contradictions_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let kept = "--frames 3 --budget 50 --guide none --reconstruct pull-push --json kept.json";
    succeeds(folder.path(), &format!("render {HEAD} -o kept {kept}"));
    assert!(frames(folder.path(), "kept.json").iter().all(|frame| frame["plan"]["way"] == "colours"));
    succeeds(
        folder.path(),
        &format!("render {HEAD} -o masks --frames 3 --budget 50 --keep frame,mask,motion"),
    );
    assert!(folder.path().join("masks/mask_0002.png").exists());
    let refused = |flags: &str, status, part: &str| {
        let said = fails(folder.path(), &format!("render {HEAD} -o no {flags}"), status);
        assert!(said.contains(part), "{said}");
    };
    refused("--quality fixed --budget 4", 2, "leave out one of them");
    refused("--budget 0", 1, "above 0");
    refused("--budget 4 --transparent", 1, "--transparent");
    let said = fails(folder.path(), "bench march head --dims 16,16,16 --budget 4", 1);
    assert!(said.contains("leave out --quality and --budget"), "{said}");
}
