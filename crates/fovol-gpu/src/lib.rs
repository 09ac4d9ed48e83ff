//! GPU access: one [`Gpu`] that renderer, networks and viewer share.
//!
//! A device is opened by name ([`AdapterRequest`]) or lent by its owner. Failures are a [`GpuError`], never a
//! panic. The rest serves all users of a device: shaders and bind groups ([`shader!`], [`binding`]), readback
//! ([`read`]), and times of passes ([`Timing`]).
//!
//! ```no_run
//! use fovol_gpu::{AdapterRequest, Gpu};
//!
//! let gpu = Gpu::open(&"gpu:nvidia".parse::<AdapterRequest>()?.or_environment())?;
//! println!("{} by {}", gpu.info().name, gpu.info().backend);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod adapter;
pub mod binding;
mod checks;
mod choices;
mod constants;
mod device;
mod error;
mod gate;
pub mod layout;
mod matrices;
mod pass;
mod pipeline_cache;
mod readback;
mod shader;
mod timing;
mod tuner;

pub use adapter::{ADAPTER_VARIABLE, AdapterRequest, adapters};
pub use checks::{CHECKS_VARIABLE, Checks};
pub use choices::Choices;
pub use constants::Constant;
pub use device::Gpu;
pub use error::{GpuError, Result};
pub use gate::Pause;
pub use matrices::{MATRICES_VARIABLE, Matrices};
pub use pass::{Commands, Pass};
pub use pipeline_cache::{CACHE_VARIABLE, abandon_cache};
pub use readback::{Arrival, Landing, read, read_picture};
pub use shader::Shader;
pub use timing::{PassTime, Timing};
pub use tuner::Tuner;
/// Kind of device that an adapter is; see [`adapters`].
pub use wgpu::DeviceType;

/// The examples of the README, for doctests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExamples;
