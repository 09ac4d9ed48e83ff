//! Filling of unsampled pixels.

pub mod doubled;
pub mod pyramid;
pub mod spread;
