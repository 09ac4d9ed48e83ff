//! The picture: view, marks over it, navigation.

pub(crate) mod marks;
pub mod navigation;
pub(crate) mod picture_view;
