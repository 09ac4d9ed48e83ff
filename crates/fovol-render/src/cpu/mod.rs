//! Rendering on CPUs: the scalar specification of image formation, and its SIMD twins.
//!
//! [`march`] is the specification. [`Renderer`] marches a scene in SIMD lanes of the best instruction set of the CPU
//! ([`Simd`]). It reads voxels from [bricks](crate::scene::Bricks). Primary rays skip empty space by
//! [macrocells](crate::scene::Macrocells), shadow rays by columns along the light.

mod adaptive_mask;
mod compact;
mod direct;
mod few_shadow_rays;
mod field;
mod fine;
mod in_turn;
mod in_vectors;
mod kernel;
mod lanes;
mod layered;
pub(crate) mod light_columns;
mod light_crossing;
mod light_path;
mod light_sweep;
pub mod march;
mod march_memory;
mod march_order;
mod mask;
mod medium;
mod modes;
mod other_shadows;
mod packet;
mod prepared;
mod prepared_layer;
mod renderer;
mod shadow_grid;
mod shadow_pool;
mod shadow_rays;
mod simd;
mod skip;
mod sparse_frame;
mod thinning;
mod tile_order;
mod volumes;

pub use adaptive_mask::adaptive_mask;
pub use compact::compact;
pub use direct::{DirectSamples, direct, mask_of};
pub use few_shadow_rays::FewShadowRays;
pub use fovol_simd::Simd;
pub use mask::{mask, sampled};
pub use renderer::{RenderOptions, Renderer};
pub use simd::{available_simd, best_simd};
pub use sparse_frame::sparse_frame;
