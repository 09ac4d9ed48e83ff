//! Tensors on a device: memory layout and precision.

mod layout;
mod precision;

pub use layout::{BLOCK, MOMENT_GROUPS, Place, Shape, Sizes, padded};
pub use precision::{Precision, halved};
