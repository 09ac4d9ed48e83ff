//! W-shaped networks: a U-Net, and kernels that filter a picture.

mod config;
mod flat;
mod options;
mod walk;

pub use config::WNetConfig;
pub use options::{Accumulation, Direct, Feedback, Fill, Filtering, Fresh, Kernels, Prediction, WNetOptions};
