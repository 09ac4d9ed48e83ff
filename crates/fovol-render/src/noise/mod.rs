//! The noise that decides which pixels are sampled.

mod asset;
mod kernel;
mod kind;
mod min_tree;
mod pattern;
mod random;
mod size;
mod source;
#[cfg(feature = "noise-statistics")]
pub mod statistics;
mod void_and_cluster;

pub use asset::{decode_ranks, encode_ranks};
pub use kind::NoiseKind;
pub(crate) use random::{hash, unit};
pub use size::NoiseSize;
pub use source::{FrameNoise, Noise};
pub use void_and_cluster::{STBN_SEED, bytes_of_making_ranks, ranks};
