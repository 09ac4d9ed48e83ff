//! Networks as lists of layers. All engines, the ONNX exporter and the trainer work from these plans.

mod build;
mod config;
mod deepfovea;
mod definition;
mod layers;
mod tensor;
#[cfg(test)]
mod tests;
mod wnet;

pub use build::PlanBuilder;
pub use config::{Named, NetworkConfig};
pub use deepfovea::DeepFoveaConfig;
pub use definition::{Inputs, Plan, StateTensor};
pub use layers::*;
pub use tensor::{Parameter, TensorId, TensorSpec};
pub use wnet::{
    Accumulation, Direct, Feedback, Fill, Filtering, Fresh, Kernels, Prediction, WNetConfig, WNetOptions,
};
