//! The scene as marchers on processors and GPUs read it: voxels in bricks, empty space, tables of the transfer function,
//! and where rays take their samples.

mod bricks;
mod extinction_table;
mod macrocells;
mod ray_result;
mod segment;
mod transfer_table;

pub(crate) use bricks::half_resolution;
pub use bricks::{BRICK, BrickData, BrickLayout, Bricks, MaybeNan};
pub(crate) use extinction_table::{COLOURS, ExtinctionTable};
pub use macrocells::Macrocells;
pub use ray_result::RayResult;
pub use segment::{LightPath, Segment, Segments};
pub(crate) use segment::{SHADOW_START, SHADOW_STEP};
pub(crate) use transfer_table::{MAX_BLUE, MAX_RED_GREEN, TransferTable, corrected_opacity};
