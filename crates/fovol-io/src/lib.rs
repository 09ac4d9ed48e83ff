//! Volumes, images, video and data sets, in and out.
//!
//! Cargo features, of which the first three are on by default: `files` for volume files and pictures, `video` for clips,
//! `procedural` for volumes that the program makes, `download` for published volumes. Transfer functions are always read.

#[cfg(feature = "files")]
pub mod atomic;
pub mod dataset;
mod error;
#[cfg(test)]
mod fault;
#[cfg(any(feature = "download", feature = "remote"))]
mod http;
#[cfg(feature = "files")]
pub mod image;
pub mod natural_order;
pub mod procedural;
#[cfg(feature = "files")]
mod stream;
pub mod transfer_function;
#[cfg(feature = "video")]
pub mod video;
#[cfg(feature = "files")]
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

/// The examples of the README, for doctests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExamples;
