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
mod frames;
mod layer;
mod motion;
mod network;
mod norm;
mod pack;
mod page_buf;
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
mod spread;
mod state;
mod tensor;
mod tensor_buf;
mod vec4;
mod warp;

pub use crate::FrameInput;
pub use calibrate::calibrate;
pub use element::Element;
pub use fovol_simd::Simd;
pub use network::Network;
pub use peak::peak_flops;
pub use precision::{Arithmetic, Precision};
pub use state::State;
pub use tensor::{AnyTensor, Tensor};
