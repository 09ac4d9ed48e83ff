//! Training of the networks of [`fovol_net`]: the same plans under autograd, what they are to minimise, and how.
//!
//! Tensors are libtorch's, \[batch, channels, rows, columns\].

pub mod loss;
pub mod network;
pub mod optimise;
