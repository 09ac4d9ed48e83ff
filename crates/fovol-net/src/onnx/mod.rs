//! Networks as ONNX files (opset 17), for runtimes other than ours.
//!
//! | Input | Shape | |
//! |---|---|---|
//! | `input` | \[1, 3 or 4, H, W\] | red, green, blue in 0…1, 0 where unsampled; fourth 1 where sampled |
//! | `motion` | \[1, 2, H, W\] | pixels to the previous position, x right, y down; only where used |
//! | `state.NAME` | \[1, c, H/s, W/s\] | what the last frame left; zeros start a clip |
//!
//! | Output | Shape | |
//! |---|---|---|
//! | `output` | \[1, 3, H, W\] | the picture, clamped to 0…1 |
//! | `next.NAME` | as `state.NAME` | what the next frame gets as `state.NAME` |
//!
//! H and W are any multiples of the metadata property `fovolnet.multiple`: pad by replication at the right
//! and bottom, and crop. The property `fovolnet.states` is a JSON list of
//! `{"name":…, "channels":c, "scale":s}`.

mod export;
mod fill;
mod filter;
mod graph;
mod model;
mod points;
mod protobuf;
#[cfg(test)]
mod tests;
mod warp;

pub use export::export;
