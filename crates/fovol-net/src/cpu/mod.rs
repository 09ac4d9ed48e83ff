//! CPU engine for networks.
//!
//! [`plain`] specifies convolutions and predicted kernels in a few lines; tests compare the fast code with it.

mod conv;
mod engine;
mod fill;
mod filter;
mod history;
mod layers;
pub mod plain;
#[cfg(test)]
mod reference_layers;
mod tensor;

pub use crate::FrameInput;
pub use engine::calibrate::calibrate;
pub use engine::network::Network;
pub use engine::peak::peak_flops;
pub use engine::precision::{Arithmetic, Precision};
pub use engine::state::State;
pub use fovol_simd::Simd;
pub use tensor::element::Element;
pub use tensor::{AnyTensor, Tensor};
