//! Sparse volume rendering: noise, mask, compaction, march and scatter.
//!
//! [`cpu`] is the specification of image formation and its fast twins; `gpu` (cargo feature `gpu`) its twins on graphics
//! processors.

pub mod cpu;
mod filtering;
#[cfg(feature = "gpu")]
pub mod gpu;
pub mod noise;

pub use filtering::Filtering;
