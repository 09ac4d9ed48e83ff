//! The renderer on the CPU: the specification, and its fast twins.
//!
//! [`march`] is image formation as plain code. [`Renderer`] marches the same scene in lanes of whatever
//! instruction set the processor has ([`Simd`]), over a brick layout of the volume ([`Bricks`]), leaving
//! empty space at once ([`Macrocells`]; for shadow rays columns along the light).

mod bricks;
mod compact;
mod direct;
mod field;
mod fine;
mod kernel;
mod lanes;
mod light_columns;
mod macrocells;
pub mod march;
mod march_order;
mod mask;
mod packet;
mod renderer;
mod scatter;
mod segment;
mod shadow_grid;
mod shadow_pool;
mod shadow_rays;
mod simd;
mod skip;
mod transfer_table;

#[cfg(feature = "gpu")]
pub(crate) use bricks::half_resolution;
pub use bricks::{BRICK, BrickData, BrickLayout, Bricks, MaybeNan};
pub use compact::compact;
pub use direct::{DirectSamples, direct, mask_of};
#[cfg(feature = "gpu")]
pub(crate) use fine::ExtinctionTable;
pub use macrocells::Macrocells;
#[cfg(feature = "gpu")]
pub(crate) use mask::Thresholds;
pub use mask::{mask, sampled};
pub use renderer::{RenderOptions, Renderer};
pub use scatter::scatter;
pub use segment::{LightPath, Segment, Segments};
pub use simd::Simd;
#[cfg(feature = "gpu")]
pub(crate) use transfer_table::TransferTable;
