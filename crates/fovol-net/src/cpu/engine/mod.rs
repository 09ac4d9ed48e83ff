//! Runs a network.

mod buffers;
pub mod calibrate;
pub mod frames;
pub mod network;
pub mod peak;
pub mod precision;
pub mod state;
