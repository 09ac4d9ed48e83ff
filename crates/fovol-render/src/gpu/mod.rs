//! The renderer on graphics processors: same-named twins of [`crate::cpu`], which is their specification.
//!
//! A [`Gpu`] is a device and its queue, opened by name ([`AdapterRequest`]) or lent by whoever has them. A [`Renderer`]
//! is a scene prepared on it; [`FrameBuffers`] are what one frame leaves there: mask, list, samples, and the sparse
//! frame that a network reads. A whole frame is put into one command encoder ([`Renderer::encode`]) and nothing comes
//! back to the host unless it is asked for ([`FrameBuffers::read_frame`] and its like).
//!
//! The host side of each step is a file here, and its shader is the file of the same name in `src/shaders`.

mod adapter;
mod binding;
mod compact;
mod device;
mod error;
mod frame_buffers;
#[cfg(test)]
mod layout;
mod march;
mod mask;
mod readback;
mod renderer;
mod scatter;
mod scene;
mod shader;
mod shadow_grid;
mod texture;
mod timing;
mod view;
mod volume_texture;

pub use adapter::{ADAPTER_VARIABLE, AdapterRequest, adapters};
pub use device::Gpu;
pub use error::{GpuError, Result};
pub use frame_buffers::FrameBuffers;
pub use mask::MaskSource;
pub use renderer::{Renderer, Sampling};
pub use timing::{Stage, StageTime};
