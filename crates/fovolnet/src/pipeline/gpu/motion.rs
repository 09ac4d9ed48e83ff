use crate::Result;
use bytemuck::{Pod, Zeroable};
use fovol_core::{Camera, FrameSize, Reprojection};
use fovol_gpu::binding::{Slot, bind_group, bind_group_layout, compute_pipeline};
use fovol_gpu::{Gpu, Shader, shader};
use fovol_net::gpu::PullPush;
use wgpu::BufferUsages;

/// Where every pixel was in the last frame.
const MOTION: Shader = shader!("../../shaders/", "motion":);

/// Edge of the workgroups; as in shaders/motion.wgsl.
const GROUP: u32 = 8;

/// What moves how. Twin of `Reprojection` in shaders/motion.wgsl.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct Uniforms {
    base: [[f32; 4]; 3],
    direction: [[f32; 4]; 3],
    parallax: [f32; 4],
    width: u32,
    height: u32,
    unused_0: u32,
    unused_1: u32,
}

impl Uniforms {
    fn new(camera: &Camera, last: &Camera, size: FrameSize) -> Self {
        let coefficients = Reprojection::new(camera, last, size).coefficients();
        let [a, b, c, d, e, f, parallax] = coefficients.map(|v| [v.x, v.y, v.z, 0.0]);
        Self {
            base: [a, b, c],
            direction: [d, e, f],
            parallax,
            width: size.width,
            height: size.height,
            unused_0: 0,
            unused_1: 0,
        }
    }
}

/// [`crate::motion()`] on a device, for frames of one size.
#[derive(Debug)]
pub struct MotionPass {
    gpu: Gpu,
    size: FrameSize,
    know: wgpu::ComputePipeline,
    shift: wgpu::ComputePipeline,
    groups: wgpu::BindGroup,
    uniforms: wgpu::Buffer,
    known: wgpu::Buffer,
    fill: PullPush,
    motion: wgpu::Buffer,
}

impl MotionPass {
    /// For frames of `size` whose samples have these inverse depths.
    pub fn new(gpu: &Gpu, size: FrameSize, inverse_depths: &wgpu::Buffer) -> Result<Self> {
        let fill = PullPush::new(gpu, size)?;
        let made = gpu.guarded("making room for motion", || {
            let storage = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
            let pixels = size.pixels() as u64;
            let uniform = BufferUsages::UNIFORM | BufferUsages::COPY_DST;
            let uniforms = gpu.buffer("reprojection", size_of::<Uniforms>() as u64, uniform);
            let known = gpu.buffer("known depths", 16 * pixels, storage);
            let motion = gpu.buffer("motion", 8 * pixels, storage);
            let slots = [Slot::Uniform, Slot::Read, Slot::Write, Slot::Read, Slot::Write];
            let layout = bind_group_layout(gpu, "motion", &slots);
            let buffers = [&uniforms, inverse_depths, &known, fill.frame_buffer(), &motion];
            let bindings = buffers.map(wgpu::Buffer::as_entire_binding);
            let groups = bind_group(gpu, "motion", &layout, &bindings);
            let pipeline = |entry_point| compute_pipeline(gpu, &MOTION, entry_point, &[&layout], &[]);
            let [know, shift] = ["know", "shift"].map(pipeline);
            Self { gpu: gpu.clone(), size, know, shift, groups, uniforms, known, fill, motion }
        })?;
        Ok(made)
    }

    /// For each pixel the way, x right and y down, as two f32.
    pub fn buffer(&self) -> &wgpu::Buffer {
        &self.motion
    }

    /// Puts the motion from `last` to `camera` into `encoder`. One frame of it in each submission.
    pub fn encode(&self, encoder: &mut wgpu::CommandEncoder, camera: &Camera, last: &Camera) -> Result<()> {
        let uniforms = Uniforms::new(camera, last, self.size);
        self.gpu.queue().write_buffer(&self.uniforms, 0, bytemuck::bytes_of(&uniforms));
        self.dispatch(encoder, &self.know);
        self.fill.encode(encoder, &self.known)?;
        self.dispatch(encoder, &self.shift);
        Ok(())
    }

    fn dispatch(&self, encoder: &mut wgpu::CommandEncoder, pipeline: &wgpu::ComputePipeline) {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, &self.groups, &[]);
        pass.dispatch_workgroups(self.size.width.div_ceil(GROUP), self.size.height.div_ceil(GROUP), 1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovol_gpu::assert_twins;

    #[test]
    fn the_shader_is_valid_and_reads_the_same_struct() {
        MOTION.check(wgpu::naga::valid::Capabilities::empty()).unwrap_or_else(|problem| panic!("{problem}"));
        assert_twins!(
            MOTION,
            "Reprojection",
            Uniforms { base, direction, parallax, width, height, unused_0, unused_1 }
        );
    }
}
