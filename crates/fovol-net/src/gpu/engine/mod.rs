//! Runs a network on a device.

mod buffers;
mod frame;
mod memory;
mod network;
mod prepared;
mod state;
mod timing;

pub use frame::DeviceInput;
pub use network::Network;
pub use state::State;
pub use timing::LayerTime;
