//! Contents of a network that its states share.

use super::timing::Stage;
use crate::gpu::kernel::{Kernel, Pipeline};
use crate::gpu::tensor::Precision;
use crate::plan::{Plan, TensorId};
use fovol_gpu::Gpu;

/// A network, prepared for a device.
pub struct Prepared {
    pub gpu: Gpu,
    pub plan: Plan,
    pub precision: Precision,
    /// Whether each tensor is stored as f16.
    pub halved: Vec<bool>,
    /// Kernels in the order of a frame.
    pub steps: Vec<Step>,
    /// States of the plan.
    pub carried: Vec<Carried>,
}

/// A kernel with its pipeline, ready to run.
pub struct Step {
    pub stage: Stage,
    pub kernel: Kernel,
    pub pipeline: Pipeline,
}

/// A state of the plan.
#[derive(Debug, Clone, Copy)]
pub struct Carried {
    /// Tensor from the last frame.
    pub previous: TensorId,
    /// Tensor for the next frame.
    pub next: TensorId,
    /// Whether the buffers of both are swapped after a frame; otherwise one is copied to the other.
    pub is_swapped: bool,
}
