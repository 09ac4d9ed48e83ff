//! What the targets of cargo-fuzz share.
//!
//! ```text
//! cargo run --release -p fovol-io --example fuzz_parsers -- --inputs 0 --write-seeds crates/fovol-io/fuzz/corpus
//! cd crates/fovol-io && cargo +nightly fuzz run nrrd
//! ```

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
