use super::buffers::Buffers;
use super::shader::ADAPTIVE_MASK;
use crate::Importance;
use bytemuck::{Pod, Zeroable};
use fovol_core::{Fovea, FrameSize, Region};
use fovol_gpu::binding::{Slot, bind_group, bind_group_layout, compute_pipeline};
use fovol_gpu::{Gpu, Pass};
use wgpu::BufferUsages;

/// Importance on the device; see [`Importance`].
#[derive(Debug, Clone, Copy)]
pub struct DeviceImportance<'a> {
    /// The importance of each cell of `cells_of`, row by row: f32, at least 0.25 and 1 on average.
    pub cells: &'a wgpu::Buffer,
    /// The region in which it is known; elsewhere it is 1.
    pub cells_of: Region,
    /// The region in which samples are taken.
    pub region: Region,
}

/// Where importance is known, as the shader reads it. Twin of `AdaptiveSettings` in shaders/adaptive_mask.wgsl.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct AdaptiveSettings {
    region_from: [u32; 2],
    region_size: [u32; 2],
    known_from: [u32; 2],
    known_size: [u32; 2],
    columns: u32,
    scale: f32,
}

/// Numbers before the bins of keys, and the bins; as in shaders/adaptive_mask.wgsl.
const COUNTS: u64 = 2 + (20 << 9);

/// The pipelines that decide which pixels are sampled where densities follow importance.
#[derive(Debug)]
pub struct AdaptiveMaskPass {
    layout: wgpu::BindGroupLayout,
    weigh: wgpu::ComputePipeline,
    limit: wgpu::ComputePipeline,
    choose: wgpu::ComputePipeline,
}

/// The memory of the pass for frames of one size.
#[derive(Debug)]
pub struct AdaptiveBuffers {
    settings: wgpu::Buffer,
    falloffs: wgpu::Buffer,
    keys: wgpu::Buffer,
    counts: wgpu::Buffer,
}

impl AdaptiveBuffers {
    pub fn new(gpu: &Gpu, size: FrameSize) -> Self {
        let storage = BufferUsages::STORAGE | BufferUsages::COPY_DST;
        let uniform = BufferUsages::UNIFORM | BufferUsages::COPY_DST;
        Self {
            settings: gpu.buffer("adaptive mask", size_of::<AdaptiveSettings>() as u64, uniform),
            falloffs: gpu.buffer("falloffs", 4 * u64::from(size.width + size.height), storage),
            keys: gpu.buffer("keys", 4 * size.pixels() as u64, storage),
            counts: gpu.buffer("counts of keys", 4 * COUNTS, storage),
        }
    }

    /// Uploads the fovea of a frame with `levels` ranks, and where its `importance` is known.
    pub fn set(
        &self,
        gpu: &Gpu,
        (fovea, size): (&Fovea, FrameSize),
        levels: u32,
        importance: &DeviceImportance<'_>,
    ) {
        let columns = (0..size.width).map(|x| fovea.falloff_x(x, size));
        let rows = (0..size.height).map(|y| fovea.falloff_y(y, size));
        let falloffs: Vec<f32> = columns.chain(rows).map(|falloff| falloff as f32).collect();
        gpu.queue().write_buffer(&self.falloffs, 0, bytemuck::cast_slice(&falloffs));
        let DeviceImportance { cells_of, region, .. } = importance;
        let [from, extent] = [
            |region: &Region| [region.x, region.y],
            |region: &Region| [region.size.width, region.size.height],
        ];
        let settings = AdaptiveSettings {
            region_from: from(region),
            region_size: extent(region),
            known_from: from(cells_of),
            known_size: extent(cells_of),
            columns: Importance::cells_of(*cells_of)[0] as u32,
            scale: 1.0 / levels as f32,
        };
        gpu.queue().write_buffer(&self.settings, 0, bytemuck::bytes_of(&settings));
    }
}

impl AdaptiveMaskPass {
    /// The pipelines on the device of `gpu`.
    pub fn new(gpu: &Gpu) -> Self {
        use Slot::{Read, Uniform, Write};
        let slots = [Uniform, Uniform, Read, Read, Write, Read, Write, Write, Uniform];
        let layout = bind_group_layout(gpu, "adaptive mask", &slots);
        let pipeline = |entry_point| compute_pipeline(gpu, &ADAPTIVE_MASK, entry_point, &[&layout], &[]);
        Self { weigh: pipeline("weigh"), limit: pipeline("limit"), choose: pipeline("choose"), layout }
    }

    /// Binds the `importance` of a frame, whose fixed mask is in `buffers` and becomes an adaptive one.
    pub fn bind(
        &self,
        gpu: &Gpu,
        buffers: &Buffers,
        adaptive: &AdaptiveBuffers,
        importance: &wgpu::Buffer,
    ) -> wgpu::BindGroup {
        let buffers = [
            &buffers.extent,
            &buffers.mask_settings,
            &buffers.tile,
            &adaptive.falloffs,
            &buffers.mask,
            importance,
            &adaptive.keys,
            &adaptive.counts,
            &adaptive.settings,
        ];
        bind_group(gpu, "adaptive mask", &self.layout, &buffers.map(wgpu::Buffer::as_entire_binding))
    }

    /// Clears what earlier frames have counted.
    pub fn clear(encoder: &mut wgpu::CommandEncoder, adaptive: &AdaptiveBuffers) {
        encoder.clear_buffer(&adaptive.counts, 0, None);
    }

    /// Decides the pixels of a frame of `size`.
    pub fn dispatch(&self, pass: &mut Pass<'_>, group: &wgpu::BindGroup, size: FrameSize) {
        let every = [size.width.div_ceil(64) * 2, size.height.div_ceil(8)];
        pass.set_bind_group(0, group, &[]);
        for (pipeline, [x, y]) in [(&self.weigh, every), (&self.limit, [1, 1]), (&self.choose, every)] {
            pass.set_pipeline(pipeline);
            pass.dispatch_workgroups(x, y, 1);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovol_gpu::assert_twins;

    #[test]
    fn the_shader_reads_the_same_struct() {
        assert_twins!(
            ADAPTIVE_MASK,
            "AdaptiveSettings",
            AdaptiveSettings { region_from, region_size, known_from, known_size, columns, scale }
        );
    }
}
