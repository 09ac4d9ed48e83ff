//! The scene as the marchers on CPU and GPU read it.
//!
//! It holds voxels in bricks, empty space, tables of the transfer function, and the positions of samples along rays.

mod brick_layout;
mod bricks;
mod extinction_table;
mod macrocells;
mod ray_result;
mod segment;
mod transfer_table;

pub use brick_layout::{BRICK, BrickLayout};
pub(crate) use bricks::half_resolution;
pub use bricks::{BrickData, Bricks, MaybeNan};
pub(crate) use extinction_table::{COLOURS, ExtinctionTable};
pub use macrocells::Macrocells;
pub use ray_result::RayResult;
pub use segment::{LightPath, Segment, Segments};
pub(crate) use segment::{SHADOW_START, SHADOW_STEP};
pub(crate) use transfer_table::{MAX_BLUE, MAX_RED_GREEN, TransferTable, corrected_opacity};
