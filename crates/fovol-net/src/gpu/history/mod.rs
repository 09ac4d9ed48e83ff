//! Layers that carry pictures and samples from frame to frame.

pub mod accumulate;
pub mod points;
pub mod warp;
