//! The renderer on GPUs: same-named twins of [`crate::cpu`], which is their specification.
//!
//! A [`Renderer`] is a scene prepared on a device ([`fovol_gpu::Gpu`]). [`FrameBuffers`] hold the outputs of one frame:
//! mask, list, samples, and the sparse frame that a network reads. [`Renderer::encode`] puts a whole frame into one
//! command encoder. Nothing returns to the host unless the caller reads it, for example with
//! [`FrameBuffers::read_frame`].
//!
//! The host side of each step is a file here, and its shader is the file of the same name in `src/shaders`.

mod adaptive_mask;
mod buffers;
mod compact;
mod error;
mod frame_buffers;
mod guide_list;
mod layers;
mod light_columns;
mod list_buffers;
mod march;
mod march_tuner;
mod march_variant;
mod mask;
mod mask_limits;
mod renderer;
mod scatter;
mod scene;
mod scene_kind;
mod scene_numbers;
mod shader;
mod shadow_grid;
mod stage;
mod stages;
mod strategy;
mod tables;
mod texture;
mod view;
mod volume_texture;

pub use adaptive_mask::DeviceImportance;
pub use error::{Error, Result};
pub use frame_buffers::FrameBuffers;
pub use guide_list::{GuideList, GuideSamples};
pub use list_buffers::ListBuffers;
pub use march_tuner::PlayedMarch;
pub use mask_limits::MaskSource;
pub use renderer::{Renderer, Sampling};
pub use stage::Stage;
pub use strategy::{MarchStrategy, Pool};
