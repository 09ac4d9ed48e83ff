use super::scene_kind::{SceneKind, scene_layout};
use super::shader::{SHADOW_GRID, SHADOW_GRID_FILTERED};
use super::texture::texture;
use super::volume_texture::TexelKind;
use bytemuck::{Pod, Zeroable};
use fovol_gpu::binding::{Slot, bind_group, bind_group_layout, compute_pipeline};
use fovol_gpu::{Gpu, Result};
use wgpu::{BufferUsages, TextureFormat, TextureUsages};

/// Threads of a workgroup along each axis; as in shaders/shadow_grid.wgsl.
const GROUP: u32 = 4;
/// Shadow rays of one submission: drivers reset a device that is silent for seconds.
const RAYS: usize = 1 << 22;

/// Some slices of the grid, as their shader reads them. Twin of `Slab` in shaders/shadow_grid.wgsl.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct Slab {
    end: [u32; 3],
    first: u32,
}

/// The pass that fills shadow grids with the transmittance towards the light.
#[derive(Debug)]
pub struct ShadowGridPass {
    layout: wgpu::BindGroupLayout,
    scene_layout: wgpu::BindGroupLayout,
}

impl ShadowGridPass {
    /// The pass on the device of `gpu`, for volumes of such texels.
    pub fn new(gpu: &Gpu, texels: TexelKind) -> Self {
        let layout = bind_group_layout(gpu, "shadow grid", &[Slot::Uniform, Slot::Stored]);
        Self { layout, scene_layout: scene_layout(gpu, texels) }
    }

    /// Fills a grid of `dims`, half those of the volume in `scene`, with the transmittance towards the light.
    ///
    /// # Errors
    /// A device that is lost or has no memory left.
    pub fn fill(
        &self,
        gpu: &Gpu,
        kind: SceneKind,
        scene: &wgpu::BindGroup,
        dims: [usize; 3],
    ) -> Result<wgpu::Texture> {
        gpu.guarded("filling the grid of shadows", || {
            let layouts = [&self.scene_layout, &self.layout];
            let shader = if kind.texels == TexelKind::Filtered { SHADOW_GRID_FILTERED } else { SHADOW_GRID };
            let pipeline = compute_pipeline(gpu, &shader, "fill_shadow_grid", &layouts, &kind.constants());
            let grid = shadow_texture(gpu, dims);
            let [nx, ny, nz] = dims;
            let slices = (RAYS / (nx * ny)).max(1);
            for first in (0..nz).step_by(slices) {
                let end = nz.min(first + slices);
                let slab = Slab { end: [nx as u32, ny as u32, end as u32], first: first as u32 };
                let group = self.bind(gpu, slab, &grid);
                let mut encoder =
                    gpu.device().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
                let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
                pass.set_pipeline(&pipeline);
                pass.set_bind_group(0, scene, &[]);
                pass.set_bind_group(1, &group, &[]);
                let threads = [slab.end[0], slab.end[1], slab.end[2] - slab.first];
                let [x, y, z] = threads.map(|n| n.div_ceil(GROUP));
                pass.dispatch_workgroups(x, y, z);
                drop(pass);
                gpu.enqueue([encoder.finish()]);
            }
            grid
        })
    }

    fn bind(&self, gpu: &Gpu, slab: Slab, grid: &wgpu::Texture) -> wgpu::BindGroup {
        let uniform = gpu.device().create_buffer(&wgpu::BufferDescriptor {
            label: Some("slab"),
            size: size_of::<Slab>() as u64,
            usage: BufferUsages::UNIFORM | BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        gpu.queue().write_buffer(&uniform, 0, bytemuck::bytes_of(&slab));
        let view = grid.create_view(&wgpu::TextureViewDescriptor::default());
        let resources = [uniform.as_entire_binding(), wgpu::BindingResource::TextureView(&view)];
        bind_group(gpu, "shadow grid", &self.layout, &resources)
    }
}

/// A texture for the transmittance towards the light on a grid of `dims`.
///
/// Like the CPU's it has 8 bits a voxel that count; of the formats that shaders may write and filter everywhere this is
/// the narrowest.
pub fn shadow_texture(gpu: &Gpu, dims: [usize; 3]) -> wgpu::Texture {
    texture(gpu, "shadow grid", dims, TextureFormat::Rgba8Unorm, TextureUsages::STORAGE_BINDING)
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovol_gpu::assert_twins;

    #[test]
    fn shaders_read_the_same_struct() {
        assert_twins!(SHADOW_GRID, "Slab", Slab { end, first });
    }
}
