//! Shared code of the fuzz targets.
//!
//! ```text
//! cd crates/fovol-net
//! mkdir -p fuzz/corpus/weights fuzz/corpus/pickle
//! cp tests/reference/*.pt tests/reference/state_dict.safetensors fuzz/corpus/weights
//! for name in state_dict checkpoint; do
//!     unzip -p tests/reference/$name.pt $name/data.pkl > fuzz/corpus/pickle/$name
//! done
//! cargo +nightly fuzz run weights -- -malloc_limit_mb=64
//! cargo +nightly fuzz run pickle -- -malloc_limit_mb=64
//! ```

use fovol_net::Weights;
use fovol_net::plan::{NetworkConfig, WNetConfig};
use fovol_net::weights::StateDict;
use std::io::{Cursor, Write};
use std::sync::LazyLock;
use zip::result::ZipResult;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipArchive, ZipWriter};

/// A file that PyTorch saved.
const SAVED: &[u8] = include_bytes!("../../tests/reference/state_dict.pt");

/// The archive of [`SAVED`] without its pickle.
static STORAGES: LazyLock<Vec<u8>> =
    LazyLock::new(|| without_pickle().expect("the reference file is a sound archive"));

/// Parses `bytes` as a weights file.
///
/// # Panics
/// When the parser panics, or its error is not one line of plain text.
pub fn weights(bytes: &[u8]) {
    if let Err(problem) = Weights::parse(bytes) {
        check(&problem);
    }
    // The network of the reference file has no name, so its configuration is given.
    let config = WNetConfig::paper().with(|options| {
        (options.encoder, options.decoder) = (vec![4, 4], vec![4]);
    });
    let state = StateDict::parse(bytes);
    match state.and_then(|state| state.weights(&NetworkConfig::WNet(config.expect("two encoders and a decoder make a U-Net")))) {
        Ok(weights) => assert_eq!(weights.arrays().len(), 20),
        Err(problem) => check(&problem),
    }
}

/// Parses the reference file with `bytes` as its pickle. The archive's checksums would otherwise reject most
/// changes.
///
/// # Panics
/// When the parser panics, or its error is not one line of plain text.
pub fn pickle(bytes: &[u8]) {
    weights(&with_pickle(bytes).expect("a pickle can be added to an archive"));
}

fn check(problem: &str) {
    assert!(!problem.contains(char::is_control) && problem.len() < 1000, "{problem:?}");
}

fn without_pickle() -> ZipResult<Vec<u8>> {
    let mut saved = ZipArchive::new(Cursor::new(SAVED))?;
    let mut rest = ZipWriter::new(Cursor::new(Vec::new()));
    for index in 0..saved.len() {
        let file = saved.by_index_raw(index)?;
        if !file.name()?.ends_with("/data.pkl") {
            rest.raw_copy_file(file)?;
        }
    }
    Ok(rest.finish()?.into_inner())
}

fn with_pickle(bytes: &[u8]) -> ZipResult<Vec<u8>> {
    let mut zip = ZipWriter::new_append(Cursor::new(STORAGES.clone()))?;
    let stored = SimpleFileOptions::default().compression_method(CompressionMethod::Stored);
    zip.start_file("state_dict/data.pkl", stored)?;
    zip.write_all(bytes)?;
    Ok(zip.finish()?.into_inner())
}
