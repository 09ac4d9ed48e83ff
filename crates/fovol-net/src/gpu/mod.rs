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
//! use fovol_core::{Frame, FrameSize, SparseFrame};
//! use fovol_gpu::{AdapterRequest, Gpu};
//! use fovol_net::gpu::{FrameInput, Network, Precision};
//! use fovol_net::{Weights, plan::Named};
//!
//! let gpu = Gpu::open(&AdapterRequest::Hardware)?;
//! let weights = Weights::shipped(Named::WNetFast)?;
//! let network = Network::new(&gpu, weights.config.plan()?, &weights, Precision::Auto)?;
//! let size = FrameSize::default();
//! let mut state = network.state(size)?;
//! let sparse = SparseFrame::from(&Frame::new(size));
//! let input = FrameInput { sparse: &sparse, motion: None };
//! let frame = network.reconstruct(&input, &mut state)?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Each layer has a file in `conv`, `fill`, `history` or `layers` for the host, and a shader of the same name in
//! `src/shaders`. [`PullPush`] is the
//! twin of [`crate::Fill::PullPush`].

mod conv;
mod engine;
mod fill;
mod history;
mod kernel;
mod layers;
mod tensor;

pub use crate::FrameInput;
pub use engine::{DeviceInput, LayerTime, Network, State};
pub use fill::PullPush;
pub use tensor::Precision;
