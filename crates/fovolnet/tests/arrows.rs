//! Crates may depend on each other in one direction only: words and device, organs, body, faces.

use std::path::Path;
use toml::Table;

/// Layer of a crate. A crate may depend on lower layers only.
fn layer(name: &str) -> u32 {
    match name {
        "fovol-core" | "fovol-gpu" | "fovol-simd" => 0,
        "fovol-io" | "fovol-metrics" | "fovol-render" | "fovol-net" => 1,
        "fovolnet" => 2,
        "fovolnet-c" | "fovolnet-cli" | "fovolnet-viewer" => 3,
        other => panic!("{other} has no layer yet: give it one here and in ARCHITECTURE.md"),
    }
}

#[test]
fn arrows_run_one_way() {
    let manifests = manifests();
    let members: Vec<&str> = manifests.iter().map(|(name, _)| name.as_str()).collect();
    let mut arrows = 0;
    for (from, manifest) in &manifests {
        let kinds = ["dependencies", "dev-dependencies", "build-dependencies"];
        let dependencies =
            kinds.iter().filter_map(|kind| manifest.get(*kind)?.as_table()).flat_map(Table::keys);
        for to in dependencies.filter(|name| members.contains(&name.as_str())) {
            assert!(layer(to) < layer(from), "{from} must not depend on {to}");
            arrows += 1;
        }
    }
    assert!(arrows >= members.len() - 1, "the crates of the workspace were not found: {members:?}");
}

#[test]
fn the_words_know_no_files_and_no_devices() {
    let manifests = manifests();
    let (_, core) = manifests.iter().find(|(name, _)| name == "fovol-core").unwrap();
    let allowed = ["bytemuck", "glam", "half", "rayon", "serde", "thiserror"];
    for dependency in core["dependencies"].as_table().unwrap().keys() {
        assert!(allowed.contains(&dependency.as_str()), "fovol-core must not depend on {dependency}");
    }
}

/// Names and manifests of all crates of the workspace.
fn manifests() -> Vec<(String, Table)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let folders = ["crates", "apps"].into_iter().flat_map(|kind| std::fs::read_dir(root.join(kind)).unwrap());
    let folders = folders.map(|folder| folder.unwrap().path()).chain([root.join("bindings/c")]);
    let files = folders.map(|folder| folder.join("Cargo.toml")).filter(|file| file.is_file());
    let read = |file| {
        let manifest: Table = std::fs::read_to_string(file).unwrap().parse().unwrap();
        (manifest["package"]["name"].as_str().unwrap().to_owned(), manifest)
    };
    files.map(read).collect()
}
