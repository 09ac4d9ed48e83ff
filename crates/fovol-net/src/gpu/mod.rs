//! GPU engine for networks. It runs the plans of [`crate::cpu`], which is its specification.
//!
//! A [`Network`] is a plan with its weights on a device ([`fovol_gpu::Gpu`]). A [`State`] holds what one sequence
//! carries from frame to frame, and memory for its frames.
//!
//! [`Network::encode`] records a frame in one command encoder, from a sparse frame on the device to a full one
//! ([`State::frame_buffer`]). Nothing is copied to the host unless the caller asks for it. [`Network::reconstruct`]
//! takes and returns frames of the host:
//!
//! ```no_run
//! use fovol_core::{Frame, FrameSize};
//! use fovol_gpu::{AdapterRequest, Gpu};
//! use fovol_net::gpu::{FrameInput, Network, Precision};
//! use fovol_net::{Weights, plan::Named};
//!
//! let gpu = Gpu::open(&AdapterRequest::Hardware)?;
//! let weights = Weights::shipped(Named::WNetFast)?;
//! let network = Network::new(&gpu, weights.config.plan()?, &weights, Precision::Auto)?;
//! let size = FrameSize::default();
//! let mut state = network.state(size)?;
//! let input = FrameInput { sparse: &Frame::new(size), motion: None };
//! let frame = network.reconstruct(&input, &mut state)?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Each layer has a file here for the host, and a shader of the same name in `src/shaders`. [`PullPush`] is the
//! twin of [`crate::Fill::PullPush`].

mod accumulate;
mod buffers;
mod conv;
mod conv_weights;
mod filter;
mod frame;
mod kernel;
mod layer;
mod memory;
mod network;
mod norm;
mod pipelines;
mod points;
mod pointwise;
mod precision;
mod pull_push;
mod pyramid;
mod reshape;
mod shader;
mod spread;
mod state;
mod tensor;
mod timing;
mod warp;

pub use crate::FrameInput;
pub use frame::DeviceInput;
pub use network::Network;
pub use precision::Precision;
pub use pull_push::PullPush;
pub use state::State;
pub use timing::LayerTime;
