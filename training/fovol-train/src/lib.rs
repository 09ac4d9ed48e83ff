//! Training of the networks of [`fovol_net`]: the same plans under autograd, what they are to minimise, and how.
//!
//! Tensors are libtorch's, \[batch, channels, rows, columns\]. Functions panic where libtorch itself fails, as when
//! memory runs out; what a caller can be wrong about is an [`Error`].

pub mod clips;
mod error;
pub mod lesson;
pub mod loss;
pub mod mask_noise;
pub mod network;
pub mod optimise;
pub mod terminal;
pub mod trainer;

pub use error::{Error, Result};
