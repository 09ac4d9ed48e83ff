//! Cache of compute pipelines, so that each is compiled once.

use super::Kernel;
use fovol_gpu::Gpu;
use fovol_gpu::binding::{Slot, bind_group_layout, compute_pipeline};
use std::collections::HashMap;

/// A compiled entry point with values for its constants.
#[derive(Debug, Clone)]
pub struct Pipeline {
    pub layout: wgpu::BindGroupLayout,
    pub pipeline: wgpu::ComputePipeline,
}

/// Shader, entry point, and bits of the constants.
type Key = (&'static str, &'static str, Vec<u64>);

/// Pipelines that have been compiled.
#[derive(Debug, Default)]
pub struct Pipelines {
    made: HashMap<Key, Pipeline>,
}

impl Pipelines {
    /// Returns the pipeline of `kernel`, and compiles it if needed.
    pub fn of(&mut self, gpu: &Gpu, kernel: &Kernel) -> Pipeline {
        let constants = kernel.constants.iter().map(|(_, value)| value.to_bits()).collect();
        let key = (kernel.shader.name(), kernel.entry_point, constants);
        self.made.entry(key).or_insert_with(|| made(gpu, kernel)).clone()
    }
}

fn made(gpu: &Gpu, kernel: &Kernel) -> Pipeline {
    let slots: Vec<Slot> = kernel.operands.iter().map(|operand| operand.slot()).collect();
    let layout = bind_group_layout(gpu, kernel.entry_point, &slots);
    let pipeline = compute_pipeline(gpu, &kernel.shader, kernel.entry_point, &[&layout], &kernel.constants);
    Pipeline { layout, pipeline }
}
