use bytemuck::{Pod, Zeroable};
use fovol_core::{FrameSize, Region};
use fovol_gpu::binding::{Slot, bind_group, bind_group_layout, compute_pipeline};
use fovol_gpu::{Gpu, Shader, shader};
use fovol_render::Importance;
use fovol_render::gpu::DeviceImportance;
use wgpu::BufferUsages;

/// Shader that finds where the next frame needs samples.
const IMPORTANCE: Shader = shader!("../../../shaders/", "importance":);

/// Twin of `ImportanceSettings` in shaders/importance.wgsl.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct ImportanceSettings {
    region_from: [u32; 2],
    region_size: [u32; 2],
    width: u32,
    after_width: u32,
}

/// GPU twin of [`crate::guide::importance_of_ratios`] and [`crate::guide::importance_of_colours`], for frames of one size.
#[derive(Debug)]
pub struct ImportancePass {
    gpu: Gpu,
    width: u32,
    settings: wgpu::Buffer,
    importance: wgpu::Buffer,
    steps: [wgpu::ComputePipeline; 4],
    group: wgpu::BindGroup,
    /// Region of the last frame, if it showed anything.
    region: Option<Region>,
}

impl ImportancePass {
    /// Importance by the reconstructed frame in `frame`: colours, or light ratios of the `guide`.
    pub fn new(
        gpu: &Gpu,
        size: FrameSize,
        frame: &wgpu::Buffer,
        guide: Option<&wgpu::Buffer>,
    ) -> fovol_gpu::Result<Self> {
        use Slot::{Read, Uniform, Write};
        gpu.guarded("making room for the importance of samples", || {
            let usage = BufferUsages::UNIFORM | BufferUsages::COPY_DST;
            let settings = gpu.buffer("importance settings", size_of::<ImportanceSettings>() as u64, usage);
            let sides =
                |edge: u32| u64::from(size.width.div_ceil(edge)) * u64::from(size.height.div_ceil(edge));
            let blocks = gpu.buffer("blocks", 8 * sides(2), BufferUsages::STORAGE);
            let [errors, importance] =
                ["errors", "importance"].map(|label| gpu.buffer(label, 4 * sides(4), BufferUsages::STORAGE));
            let layout = bind_group_layout(gpu, "importance", &[Uniform, Read, Read, Write, Write, Write]);
            let bound = [&settings, frame, guide.unwrap_or(frame), &blocks, &errors, &importance];
            let group = bind_group(gpu, "importance", &layout, &bound.map(wgpu::Buffer::as_entire_binding));
            let constants = [("RATIOS", f64::from(u8::from(guide.is_some())))];
            let step = |entry_point| compute_pipeline(gpu, &IMPORTANCE, entry_point, &[&layout], &constants);
            let steps = ["make_blocks", "make_errors", "blur", "relate"].map(step);
            Self { gpu: gpu.clone(), width: size.width, settings, importance, steps, group, region: None }
        })
    }

    /// Encodes the importance for the next frame, of the frame whose scene can be seen in `region`.
    pub fn encode(&mut self, encoder: &mut wgpu::CommandEncoder, region: Option<Region>) {
        self.region = region;
        let Some(region) = region else { return };
        let settings = ImportanceSettings {
            region_from: [region.x, region.y],
            region_size: [region.size.width, region.size.height],
            width: self.width,
            after_width: 0,
        };
        self.gpu.queue().write_buffer(&self.settings, 0, bytemuck::bytes_of(&settings));
        let [columns, rows] = Importance::cells_of(region).map(|cells| cells as u32);
        let blocks = settings.region_size.map(|side| side.div_ceil(2).div_ceil(8));
        let cells = [columns, rows].map(|cells| cells.div_ceil(8));
        let mut pass = self.gpu.pass(encoder);
        pass.set_bind_group(0, &self.group, &[]);
        for (step, [x, y]) in self.steps.iter().zip([blocks, cells, cells, [1, 1]]) {
            pass.set_pipeline(step);
            pass.dispatch_workgroups(x, y, 1);
        }
    }

    /// Importance for the frame after the last encoded one, which may show the scene in `region`; `None` if nothing is known.
    pub fn known(&self, region: Option<Region>) -> Option<DeviceImportance<'_>> {
        let (cells_of, region) = (self.region?, region?);
        Some(DeviceImportance { cells: &self.importance, cells_of, region })
    }

    /// Forgets the last frame.
    pub fn reset(&mut self) {
        self.region = None;
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
        IMPORTANCE.check(Capabilities::empty()).unwrap_or_else(|problem| panic!("{problem}"));
        assert_twins!(
            IMPORTANCE,
            "ImportanceSettings",
            ImportanceSettings { region_from, region_size, width }
        );
        assert!(IMPORTANCE.source().contains(&format!("const EPSILON: f32 = {EPSILON};")));
    }
}
