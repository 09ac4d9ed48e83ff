//! CPU engine for networks.
//!
//! [`plain`] specifies convolutions and predicted kernels in a few lines; tests compare the fast code with it.

mod accumulate;
mod buffers;
mod calibrate;
mod conv;
mod doubled;
mod element;
mod filter;
mod floats;
mod frames;
mod layer;
mod lines;
mod map;
mod motion;
mod network;
mod norm;
mod numbers;
mod pack;
mod pair;
mod patch;
mod peak;
pub mod plain;
mod points;
mod pointwise;
mod precision;
mod prediction;
mod pyramid;
#[cfg(test)]
mod reference_layers;
mod reshape;
mod rows;
mod samples;
pub(crate) mod schedule;
mod simd;
mod spread;
mod state;
mod units;
mod warp;
mod words;

pub use calibrate::calibrate;
pub use element::{Bf16, Element};
pub use frames::FrameInput;
pub use map::{Map, Stored};
pub use network::Network;
pub use peak::peak_flops;
pub use precision::{Arithmetic, Precision};
pub use simd::{Simd, Work};
pub use state::State;
