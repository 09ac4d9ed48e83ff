use super::buffers::Buffers;
use super::list_buffers::GroupSize;
use super::shader::SCATTER;
use fovol_gpu::binding::{Slot, bind_group, bind_group_layout, compute_pipeline};
use fovol_gpu::{Gpu, Pass};

/// The pipeline that scatters packed samples into a sparse frame.
#[derive(Debug)]
pub struct ScatterPass {
    layout: wgpu::BindGroupLayout,
    pipeline: wgpu::ComputePipeline,
}

impl ScatterPass {
    /// The pipeline on the device of `gpu`.
    pub fn new(gpu: &Gpu) -> Self {
        let slots = [Slot::Uniform, Slot::Read, Slot::Read, Slot::Read, Slot::Read, Slot::Write, Slot::Write];
        let layout = bind_group_layout(gpu, "scatter", &slots);
        let pipeline = compute_pipeline(gpu, &SCATTER, "scatter", &[&layout], &[]);
        Self { layout, pipeline }
    }

    /// Binds the samples of the list as input and the sparse frame as output.
    pub fn bind(&self, gpu: &Gpu, buffers: &Buffers) -> wgpu::BindGroup {
        let buffers = [
            &buffers.extent,
            &buffers.listed.pixels,
            &buffers.listed.length,
            &buffers.listed.results.colours,
            &buffers.listed.results.inverse_depths,
            &buffers.frame.colours,
            &buffers.frame.inverse_depths,
        ];
        bind_group(gpu, "scatter", &self.layout, &buffers.map(wgpu::Buffer::as_entire_binding))
    }

    /// Writes the samples of the list into the cleared frame.
    pub fn dispatch(&self, pass: &mut Pass<'_>, group: &wgpu::BindGroup, length: &wgpu::Buffer) {
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, group, &[]);
        pass.dispatch_workgroups_indirect(length, GroupSize::SixtyFour.offset());
    }
}
