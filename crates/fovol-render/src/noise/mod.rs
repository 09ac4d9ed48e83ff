//! The noise that decides which pixels are sampled.

mod asset;
mod kind;
mod random;
mod spacetime;
pub mod statistics;
mod void_and_cluster;

pub use asset::{decode_ranks, encode_ranks};
pub use kind::NoiseKind;
pub(crate) use random::{hash, unit};
pub use spacetime::{FrameNoise, Noise};
pub use void_and_cluster::{NoiseSize, STBN_SEED, ranks};
