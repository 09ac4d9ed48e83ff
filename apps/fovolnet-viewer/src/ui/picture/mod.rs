//! The picture: view, marks over it, navigation, clip planes in the hand.

pub(crate) mod marks;
pub mod navigation;
pub(crate) mod picture_view;
pub(crate) mod plane_drag;
mod plane_handles;
