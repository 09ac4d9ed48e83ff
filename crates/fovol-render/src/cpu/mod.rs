//! Rendering on processors: the specification of image formation, and its fast twins.
//!
//! [`march`] is the specification, as plain code. [`Renderer`] marches a scene in SIMD lanes of the instruction set that
//! the processor has ([`Simd`]). It reads voxels from [bricks](crate::scene::Bricks) and leaves empty space at once, by
//! [macrocells](crate::scene::Macrocells) on primary rays and by columns along the light on shadow rays.

mod compact;
mod direct;
mod field;
mod fine;
mod kernel;
mod lanes;
mod light_columns;
mod light_path;
pub mod march;
mod march_order;
mod mask;
mod packet;
mod renderer;
mod scatter;
mod shadow_grid;
mod shadow_pool;
mod shadow_rays;
mod simd;
mod skip;

pub use compact::compact;
pub use direct::{DirectSamples, direct, mask_of};
#[cfg(feature = "gpu")]
pub(crate) use mask::Thresholds;
pub use mask::{mask, sampled};
pub use renderer::{RenderOptions, Renderer};
pub use scatter::scatter;
pub use simd::Simd;
