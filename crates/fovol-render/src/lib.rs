//! Sparse volume rendering: noise, mask, compaction, march and the sparse frame.
//!
//! [`scene`] prepares a volume for marching. [`cpu`] has the specification of image formation and its fast twins. `gpu`
//! (cargo feature `gpu`) has their twins on graphics processors. [`model`] tells what marching would cost there.

pub mod cpu;
mod filtering;
#[cfg(feature = "gpu")]
pub mod gpu;
mod importance;
pub mod model;
pub mod noise;
pub mod scene;
mod thresholds;

pub use filtering::Filtering;
pub use importance::Importance;

/// The examples of the README, for doctests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExamples;
