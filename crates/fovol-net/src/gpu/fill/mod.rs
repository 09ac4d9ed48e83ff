//! Filling of unsampled pixels: as layers of a network, and without one.

mod pull_push;
pub mod pyramid;
pub mod spread;

pub use pull_push::PullPush;
