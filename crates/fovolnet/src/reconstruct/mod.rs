//! Reconstruction of full frames from sparse ones.

#[cfg(feature = "gpu")]
mod device_reconstructor;
#[cfg(feature = "gpu")]
mod on_device;
mod reconstructor;
mod weights;
mod window;

#[cfg(feature = "gpu")]
pub use device_reconstructor::DeviceReconstructor;
#[cfg(feature = "gpu")]
pub(crate) use on_device::{device_precision, reconstructs};
pub use reconstructor::Reconstructor;
#[cfg(feature = "gpu")]
pub(crate) use weights::weights;
pub use window::Seen;
