//! Volumes, images, video, sessions and data sets, in and out.

pub mod atomic;
pub mod dataset;
mod error;
#[cfg(test)]
mod fault;
pub mod image;
pub mod natural_order;
pub mod procedural;
mod stream;
pub mod temporaries;
pub mod transfer_function;
pub mod video;
pub mod volume;

pub use error::{Error, Result};

/// The folder of real files that tests use where it is present: `FOVOL_TEST_DATA`, or `../shared/data`
/// beside the repository.
#[cfg(test)]
fn test_data() -> Option<std::path::PathBuf> {
    let beside = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data");
    let folder = std::env::var_os("FOVOL_TEST_DATA").map_or_else(|| beside.into(), std::path::PathBuf::from);
    if folder.is_dir() {
        return Some(folder);
    }
    println!("skipped: no test data at {}; set FOVOL_TEST_DATA", folder.display());
    None
}
