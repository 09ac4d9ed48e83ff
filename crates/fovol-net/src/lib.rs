//! Reconstruction of full frames from sparse ones.
//!
//! [`Fill`] has classical methods, which use only the samples of one frame. They are the baseline for networks.
//!
//! A network is a [`plan::Plan`], made from a configuration. [`Weights`] come from a file or a seed.
//! [`cpu::Network`] runs the network, and [`cpu::State`] holds what one sequence carries from frame to frame:
//!
//! ```
//! use fovol_core::{Frame, FrameSize, SparseFrame};
//! use fovol_net::cpu::{FrameInput, Network, Precision, Simd};
//! use fovol_net::{Weights, plan::Named};
//!
//! let config = Named::WNetFast.config();
//! let weights = Weights::random(&config, 1)?;
//! let network = Network::new(config.plan()?, &weights, Simd::best(), Precision::Auto)?;
//! let size = FrameSize::new(40, 30)?;
//! let mut state = network.state(size);
//! let sparse = SparseFrame::from(&Frame::new(size));
//! let frame = network.reconstruct(&FrameInput { sparse: &sparse, motion: None }, &mut state)?;
//! assert_eq!(frame.size(), size);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod cpu;
mod error;
mod fill;
#[cfg(feature = "gpu")]
pub mod gpu;
mod input;
pub mod onnx;
pub mod plan;
mod schedule;
pub mod weights;

pub use error::{Error, Result};
pub use fill::{Fill, FilledNumbers};
pub use input::FrameInput;
pub use weights::Weights;

/// The examples of the README, for doctests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExamples;
