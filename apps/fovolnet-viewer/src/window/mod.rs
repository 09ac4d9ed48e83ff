//! The window: its graphics device, surface and threads.

pub mod drawing_threads;
pub mod no_window;
pub mod quad;
pub mod screen;
pub mod surface;
