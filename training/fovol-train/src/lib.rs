//! Training of the networks of [`fovol_net`]: plans under autograd, losses and optimisers.
//!
//! Tensors are libtorch's, \[batch, channels, rows, columns\]. Functions panic where libtorch itself fails, for
//! example when memory runs out. Mistakes that a caller can make are an [`Error`].

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
