//! Networks on graphics processors: the same plans as [`crate::cpu`], which is their specification.
//!
//! A [`Network`] is a plan with its weights on a device ([`fovol_gpu::Gpu`]); a [`State`] is what one clip carries there
//! from frame to frame, and the memory of its frames. A frame is put into one command encoder ([`Network::encode`]):
//! it begins with a sparse frame on the device, ends with a full one ([`State::frame_buffer`]), and nothing comes back to
//! the host unless it is asked for. [`Network::reconstruct`] is the same for frames of the host:
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
//! The host side of each layer is a file here, and its shader is the file of the same name in `src/shaders`.
//! [`PullPush`] is the twin of [`crate::Fill::PullPush`].

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

pub use crate::cpu::FrameInput;
pub use frame::DeviceInput;
pub use network::Network;
pub use precision::Precision;
pub use pull_push::PullPush;
pub use state::State;
pub use timing::LayerTime;
