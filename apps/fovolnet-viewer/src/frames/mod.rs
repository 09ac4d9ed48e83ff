//! Frames: requests, the thread that makes them, quality in motion, refinement at rest.

pub mod display_mode;
pub mod engine;
pub mod frame_producer;
pub mod gaze;
pub mod presented;
pub mod shown_point;
pub mod still;
mod turnaround;
pub mod view_request;
