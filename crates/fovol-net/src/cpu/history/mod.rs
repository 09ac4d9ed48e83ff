//! Earlier frames: motion, and accumulation of their samples.

pub mod accumulate;
pub mod motion;
pub mod points;
pub mod warp;
