//! Functions shared by the targets of cargo-fuzz.
//!
//! ```text
//! cargo run --release -p fovol-io --example fuzz_parsers -- --inputs 0 --write-seeds crates/fovol-io/fuzz/corpus
//! cd crates/fovol-io && cargo +nightly fuzz run nrrd
//! ```

use fovol_io::transfer_function;
use fovol_io::volume::{Overrides, Source, parse as parse_volume};
use std::path::Path;

/// Reads `bytes` as the file `name` and looks at the last voxel.
///
/// # Panics
/// When the parser does, or when its complaint is not one line of plain text.
pub fn parse(name: &str, bytes: &[u8]) {
    match parse_volume(&Source::from_bytes(Path::new(name), bytes.to_vec()), &Overrides::default()) {
        Ok(volume) => {
            let [x, y, z] = volume.grid().dims();
            volume.value([x - 1, y - 1, z - 1]);
        }
        Err(error) => assert!(!error.to_string().contains(char::is_control), "{error:?}"),
    }
}

/// Reads `bytes` as a transfer function and looks at its ends.
///
/// # Panics
/// When the parser does, or when its complaint is not one line of plain text.
pub fn parse_transfer_function(bytes: &[u8]) {
    match transfer_function::parse(Path::new("v.tf"), &String::from_utf8_lossy(bytes), None) {
        Ok(imported) => {
            let ends = [0.0, 1.0].map(|v| imported.as_meant().evaluate(v));
            assert!(ends.as_flattened().iter().all(|c| (0.0..=1.0).contains(c)), "{ends:?}");
        }
        Err(error) => assert!(!error.to_string().contains(char::is_control), "{error:?}"),
    }
}
