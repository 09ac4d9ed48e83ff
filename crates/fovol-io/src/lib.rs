//! Volumes, images, video, sessions and data sets, in and out.

pub mod atomic;
mod error;
pub mod procedural;
pub mod volume;

pub use error::{Error, Result};
