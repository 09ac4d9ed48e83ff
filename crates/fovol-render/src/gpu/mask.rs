use super::buffers::Buffers;
use super::shader::MASK;
use fovol_core::FrameSize;
use fovol_gpu::binding::{Slot, bind_group, bind_group_layout, compute_pipeline};
use fovol_gpu::{Gpu, Pass};

/// The pipeline that decides which pixels are sampled.
#[derive(Debug)]
pub struct MaskPass {
    layout: wgpu::BindGroupLayout,
    pipeline: wgpu::ComputePipeline,
}

impl MaskPass {
    /// The pipeline on the device of `gpu`.
    pub fn new(gpu: &Gpu) -> Self {
        let slots = [Slot::Uniform, Slot::Uniform, Slot::Read, Slot::Read, Slot::Write];
        let layout = bind_group_layout(gpu, "mask", &slots);
        let pipeline = compute_pipeline(gpu, &MASK, "decide", &[&layout], &[]);
        Self { layout, pipeline }
    }

    /// Binds settings, noise and limits as input, and the mask as output.
    pub fn bind(&self, gpu: &Gpu, buffers: &Buffers) -> wgpu::BindGroup {
        let buffers =
            [&buffers.extent, &buffers.mask_settings, &buffers.tile, &buffers.limits, &buffers.mask];
        bind_group(gpu, "mask", &self.layout, &buffers.map(wgpu::Buffer::as_entire_binding))
    }

    /// Decides the pixels of a frame of `size`.
    pub fn dispatch(&self, pass: &mut Pass<'_>, group: &wgpu::BindGroup, size: FrameSize) {
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, group, &[]);
        // Words beyond the right edge are written too: masks are padded to 64 bits.
        pass.dispatch_workgroups(size.width.div_ceil(64) * 2, size.height.div_ceil(8), 1);
    }
}
