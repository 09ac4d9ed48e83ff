//! Reconstruction of full frames from sparse ones.
//!
//! [`Fill`] holds the classical alternatives that know nothing but the samples of one frame; they are
//! what a network has to beat.

mod fill;
pub mod plan;

pub use fill::Fill;
