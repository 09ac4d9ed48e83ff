//! The crates depend on each other in one direction: words and device, organs, body, faces.

use cargo_metadata::MetadataCommand;

/// The layer of a crate: it may depend on lower layers only.
fn layer(name: &str) -> u32 {
    match name {
        "fovol-core" | "fovol-gpu" => 0,
        "fovol-io" | "fovol-metrics" | "fovol-render" | "fovol-net" => 1,
        "fovolnet" => 2,
        "fovolnet-cli" | "fovolnet-viewer" => 3,
        other => panic!("{other} has no layer yet: give it one here and in ARCHITECTURE.md"),
    }
}

#[test]
fn arrows_run_one_way() {
    let manifest = concat!(env!("CARGO_MANIFEST_DIR"), "/../../Cargo.toml");
    let metadata = MetadataCommand::new().manifest_path(manifest).no_deps().exec().unwrap();
    let members: Vec<&str> = metadata.packages.iter().map(|p| p.name.as_str()).collect();
    let mut arrows = 0;
    for package in &metadata.packages {
        for dependency in package.dependencies.iter().filter(|d| members.contains(&d.name.as_str())) {
            let (from, to) = (package.name.as_str(), dependency.name.as_str());
            assert!(layer(to) < layer(from), "{from} must not depend on {to}");
            arrows += 1;
        }
    }
    assert!(arrows >= members.len() - 1, "the crates of the workspace were not found: {members:?}");
}

#[test]
fn the_words_know_no_files_and_no_devices() {
    let manifest = concat!(env!("CARGO_MANIFEST_DIR"), "/../../Cargo.toml");
    let metadata = MetadataCommand::new().manifest_path(manifest).no_deps().exec().unwrap();
    let core = metadata.packages.iter().find(|p| p.name.as_str() == "fovol-core").unwrap();
    let allowed = ["glam", "half", "rayon", "serde", "thiserror"];
    for dependency in core.dependencies.iter().filter(|d| d.kind == cargo_metadata::DependencyKind::Normal) {
        assert!(
            allowed.contains(&dependency.name.as_str()),
            "fovol-core must not depend on {}",
            dependency.name
        );
    }
}
