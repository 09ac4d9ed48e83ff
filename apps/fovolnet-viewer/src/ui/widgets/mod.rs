//! Small controls.

pub(crate) mod accept_buttons;
pub(crate) mod colour_button;
pub(crate) mod curve_points;
pub(crate) mod outline;
pub(crate) mod range_slider;
pub(crate) mod text_field;
