use bytemuck::{Pod, Zeroable};
use fovol_core::{FrameSize, Region};
use fovol_gpu::binding::{Slot, bind_group, bind_group_layout, compute_pipeline};
use fovol_gpu::{Gpu, Shader, shader};
use wgpu::BufferUsages;

/// Shader that divides samples by their guide, and multiplies the filled ratios with it.
const LIGHT_RATIO: Shader = shader!("../../../shaders/", "light_ratio":);

/// Twin of `RatioSettings` in shaders/light_ratio.wgsl.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct RatioSettings {
    region_from: [u32; 2],
    region_size: [u32; 2],
    size: [u32; 2],
    before_background: [u32; 2],
    background: [f32; 3],
    headroom: f32,
}

/// GPU twin of [`crate::guide::light_ratios`] and [`crate::guide::compose`], for frames of one size.
#[derive(Debug)]
pub struct LightRatio {
    gpu: Gpu,
    size: FrameSize,
    /// By how much pixels can be brighter than the guide.
    headroom: f32,
    settings: wgpu::Buffer,
    /// Light ratios of the samples.
    ratios: wgpu::Buffer,
    /// Composed frame.
    frame: wgpu::Buffer,
    divide: wgpu::ComputePipeline,
    compose: wgpu::ComputePipeline,
    groups: [wgpu::BindGroup; 2],
}

impl LightRatio {
    /// Light ratios of the samples in `sparse` by the guide in `guide`, which has this `headroom`. Whoever fills them leaves the full picture in `filled`.
    pub fn new(
        gpu: &Gpu,
        size: FrameSize,
        [sparse, guide, filled]: [&wgpu::Buffer; 3],
        headroom: f32,
    ) -> fovol_gpu::Result<Self> {
        use Slot::{Read, Uniform, Write};
        gpu.guarded("making room for light ratios", || {
            let storage = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
            let usage = BufferUsages::UNIFORM | BufferUsages::COPY_DST;
            let settings = gpu.buffer("light ratio", size_of::<RatioSettings>() as u64, usage);
            let [ratios, frame] = ["light ratios", "composed frame"]
                .map(|label| gpu.buffer(label, 16 * size.pixels() as u64, storage));
            let layout = bind_group_layout(gpu, "light ratio", &[Uniform, Read, Read, Read, Write]);
            let groups = [&ratios, &frame].map(|made| {
                let bound = [&settings, sparse, guide, filled, made];
                bind_group(gpu, "light ratio", &layout, &bound.map(wgpu::Buffer::as_entire_binding))
            });
            let pipeline = |entry_point| compute_pipeline(gpu, &LIGHT_RATIO, entry_point, &[&layout], &[]);
            let [divide, compose] = ["light_ratios", "compose"].map(pipeline);
            Self { gpu: gpu.clone(), size, headroom, settings, ratios, frame, divide, compose, groups }
        })
    }

    /// Encodes the light ratios of the samples. The guide covers `region`; `background` is behind everything.
    pub fn encode_ratios(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        region: Option<Region>,
        background: [f32; 3],
    ) {
        let [width, height] = region.map_or([0; 2], |region| [region.size.width, region.size.height]);
        let settings = RatioSettings {
            region_from: region.map_or([0; 2], |region| [region.x, region.y]),
            region_size: [width, height],
            size: [self.size.width, self.size.height],
            before_background: [0; 2],
            background,
            headroom: self.headroom,
        };
        self.gpu.queue().write_buffer(&self.settings, 0, bytemuck::bytes_of(&settings));
        self.dispatch(encoder, &self.divide, &self.groups[0]);
    }

    /// Encodes the frame of the filled light ratios.
    pub fn encode_frame(&self, encoder: &mut wgpu::CommandEncoder) {
        self.dispatch(encoder, &self.compose, &self.groups[1]);
    }

    fn dispatch(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        pipeline: &wgpu::ComputePipeline,
        group: &wgpu::BindGroup,
    ) {
        let mut pass = self.gpu.pass(encoder);
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, group, &[]);
        pass.dispatch_workgroups(self.size.width.div_ceil(8), self.size.height.div_ceil(8), 1);
    }

    /// Light ratios of the samples as a sparse frame: alpha is 1 where there is one.
    pub fn ratios(&self) -> &wgpu::Buffer {
        &self.ratios
    }

    /// Composed frame: RGBA as f32, row 0 on top.
    pub fn frame(&self) -> &wgpu::Buffer {
        &self.frame
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::guide::EPSILON;
    use fovol_gpu::assert_twins;
    use wgpu::naga::valid::Capabilities;

    #[test]
    fn the_shader_is_valid_and_has_the_same_numbers() {
        LIGHT_RATIO.check(Capabilities::empty()).unwrap_or_else(|problem| panic!("{problem}"));
        assert_twins!(
            LIGHT_RATIO,
            "RatioSettings",
            RatioSettings { region_from, region_size, size, background, headroom }
        );
        assert!(LIGHT_RATIO.source().contains(&format!("const EPSILON: f32 = {EPSILON};")));
    }
}
