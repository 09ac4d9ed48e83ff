//! CPU engine for networks.
//!
//! [`plain`] specifies convolutions and predicted kernels in a few lines; tests compare the fast code with it.

mod accumulate;
mod aligned_buf;
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
mod simd;
mod simd_f32;
mod spread;
mod state;
mod tensor;
mod tensor_buf;
mod warp;

pub use crate::FrameInput;
pub use calibrate::calibrate;
pub use element::{Bf16, Element};
pub use network::Network;
pub use peak::peak_flops;
pub use precision::{Arithmetic, Precision};
pub use simd::{Simd, SimdOp};
pub use state::State;
pub use tensor::{AnyTensor, Tensor};
