//! Exports networks as ONNX files (opset 17), for other runtimes.
//!
//! | Input | Shape | |
//! |---|---|---|
//! | `input` | \[1, 3 or 4, H, W\] | red, green, blue in 0…1, 0 where unsampled; fourth channel: 1 where sampled |
//! | `motion` | \[1, 2, H, W\] | pixels to the previous position, x right, y down; only where used |
//! | `state.NAME` | \[1, c, H/s, W/s\] | state from the last frame; zeros in the first frame |
//!
//! | Output | Shape | |
//! |---|---|---|
//! | `output` | \[1, 3, H, W\] | reconstructed frame, clamped to 0…1 |
//! | `next.NAME` | shape of `state.NAME` | input `state.NAME` of the next frame |
//!
//! H and W are multiples of the metadata property `fovolnet.multiple`: pad frames by replication at the right and
//! bottom, and crop the output. The property `fovolnet.states` is a JSON list of
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
