//! Three orthogonal slices beside the picture.

pub mod orientation;
mod placed_slice;
pub mod reading;
pub mod ruler;
pub mod slice_colours;
pub(crate) mod slice_marks;
mod slice_pixels;
mod slice_textures;
mod slice_view;
pub mod slices_state;
pub mod slices_view;
pub mod value_window;
