//! The scene as the marchers on CPU and GPU read it.
//!
//! It holds voxels in bricks, empty space, tables of the transfer function, and the positions of samples along rays.

mod blend;
mod blend_table;
mod brick_layout;
mod brick_lines;
mod bricks;
mod extinction_table;
mod gradient_lengths;
mod gradient_table;
mod leaving_planes;
mod light_slices;
mod macrocells;
mod raw_voxels;
mod ray_result;
mod segment;
mod transfer_table;

pub(crate) use blend::{blended, blended_results, extinction, thinned};
pub(crate) use blend_table::BlendTable;
pub use brick_layout::{BRICK, BrickLayout};
pub use bricks::{BrickData, Bricks, MaybeNan};
pub(crate) use extinction_table::{COLOURS, ExtinctionTable};
pub(crate) use gradient_lengths::greatest_gradient;
pub(crate) use gradient_table::GradientTable;
pub(crate) use light_slices::{Crossing, FIRST_STRETCH, LightSlices, SWEEP_STEP};
pub use macrocells::Macrocells;
pub use ray_result::RayResult;
pub use segment::{LightPath, Segment, Segments};
pub(crate) use segment::{SHADOW_START, SHADOW_STEP};
pub(crate) use transfer_table::{MAX_BLUE, MAX_RED_GREEN, TransferTable, corrected_opacity};
