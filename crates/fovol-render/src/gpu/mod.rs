//! The renderer on graphics processors: same-named twins of [`crate::cpu`], which is their specification.
//!
//! A [`Renderer`] is a scene prepared on a device ([`fovol_gpu::Gpu`]); [`FrameBuffers`] are what one frame leaves
//! there: mask, list, samples, and the sparse frame that a network reads. A whole frame is put into one command encoder
//! ([`Renderer::encode`]) and nothing comes back to the host unless it is asked for ([`FrameBuffers::read_frame`] and its
//! like).
//!
//! The host side of each step is a file here, and its shader is the file of the same name in `src/shaders`.

mod compact;
mod error;
mod frame_buffers;
mod march;
mod mask;
mod renderer;
mod scatter;
mod scene;
mod shader;
mod shadow_grid;
mod stage;
mod texture;
mod view;
mod volume_texture;

pub use error::{Error, Result};
pub use frame_buffers::FrameBuffers;
pub use mask::MaskSource;
pub use renderer::{Renderer, Sampling};
pub use stage::Stage;
