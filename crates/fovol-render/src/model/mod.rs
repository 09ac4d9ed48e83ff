//! Cost of marching on a GPU, by replay of the rays on a processor.
//!
//! Software Vulkan shows whether pictures are right, not how fast a GPU makes them. Here the rays of a frame are followed one by
//! one, and every look into macrocells and every sample is noted ([`Replay`]). [`cost`] puts these rays into warps as a strategy
//! does: lanes of a warp take their steps together, and wait for the longest of them. That gives whole numbers, which need
//! no GPU: the longest chain of dependent steps, steps of warps, the share of busy lanes, texture loads. With the constants of a
//! GPU ([`GpuModel`]) they give milliseconds.
//!
//! The model knows no caches, and follows plain integration only.

mod cost;
mod count;
mod gpu_model;
mod pool;
mod ray_steps;
mod rays;
mod replay;

pub use cost::{MarchCost, Order, Work, cost};
pub use gpu_model::GpuModel;
pub use replay::Replay;
