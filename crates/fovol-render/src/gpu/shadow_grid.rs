use super::layers::Layering;
use super::scene_kind::{SceneKind, scene_layout};
use super::shader::{SHADOW_GRID, SHADOW_GRID_FILTERED, SHADOW_GRID_LAYERED};
use super::texture::texture;
use super::volume_texture::TexelKind;
use crate::scene::LightSlices;
use bytemuck::{Pod, Zeroable};
use fovol_gpu::binding::{Slot, bind_group, bind_group_layout, compute_pipeline};
use fovol_gpu::{Gpu, GpuError, Result};
use wgpu::{BufferUsages, TextureFormat, TextureUsages};

/// Edge of the workgroups, in columns or texels; as in shaders/shadow_grid.wgsl.
const GROUP: u32 = 8;
/// Slices of one submission: drivers reset a device that is silent for seconds.
const SLICES: usize = 64;
/// Voxels along z that share a texel.
const LAYERS: usize = 4;

/// A slice, and how columns of light cross it. Twin of `Slice` in shaders/shadow_grid.wgsl.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Slice {
    whole: [i32; 2],
    part: [f32; 2],
    first: [i32; 2],
    columns: [u32; 2],
    size: [u32; 2],
    voxel: u32,
    deep: u32,
    down: u32,
    along: u32,
    steps: f32,
    near: f32,
}

impl Slice {
    fn new(slices: &LightSlices, number: usize) -> Self {
        let crossings = slices.crossings(number);
        let columns = slices.columns();
        let [deep, down, along] = slices.axes.map(|axis| axis as u32);
        Self {
            whole: crossings.map(|crossing| crossing.whole as i32),
            part: crossings.map(|crossing| crossing.part),
            first: columns.map(|[first, _]| first as i32),
            columns: columns.map(|[first, last]| (last - first + 1) as u32),
            size: slices.size().map(|side| side as u32),
            voxel: slices.voxel(number) as u32,
            deep,
            down,
            along,
            steps: slices.steps as f32,
            near: slices.near(),
        }
    }
}

/// The pass that fills shadow grids with the transmittance towards the light.
#[derive(Debug)]
pub struct ShadowGridPass {
    layout: wgpu::BindGroupLayout,
    scene_layout: wgpu::BindGroupLayout,
}

impl ShadowGridPass {
    /// The pass on the device of `gpu`, for volumes of such texels and layers.
    pub fn new(gpu: &Gpu, texels: TexelKind, layers: Layering) -> Self {
        let slots = [Slot::Uniform, Slot::Write, Slot::Write, Slot::Stored, Slot::Uniform];
        let layout = bind_group_layout(gpu, "shadow grid", &slots);
        Self { layout, scene_layout: scene_layout(gpu, texels, layers) }
    }

    /// Sweeps light through the `slices` of the volume of `dims` voxels in `scene`.
    ///
    /// # Errors
    /// A device that is lost or has no memory left, or whose buffers are too small.
    pub fn fill(
        &self,
        gpu: &Gpu,
        kind: SceneKind,
        scene: &wgpu::BindGroup,
        (slices, dims): (&LightSlices, [usize; 3]),
    ) -> Result<wgpu::Texture> {
        let [rows, along] = slices.columns().map(|[first, last]| (last - first + 1) as u64);
        // Entries of further volumes take as much room again, and so do lengths of gradients.
        let has_more = kind.layers.volumes > 1 || kind.layers.are_thinned();
        let bytes = 16 * rows * along * if has_more { 3 } else { 1 };
        let limit = gpu.device().limits().max_storage_buffer_binding_size;
        let mend = "average its voxels with --downsample 2 (or more), or use --shadows on";
        let limit = ("maxStorageBufferBindingSize", limit);
        GpuError::check_limit("light on its way through the volume", bytes, limit, mend)?;
        gpu.guarded("filling the grid of shadows", || {
            let layouts = [&self.scene_layout, &self.layout];
            let shader = match kind.texels {
                _ if kind.layers.are_blended() => SHADOW_GRID_LAYERED,
                TexelKind::Filtered => SHADOW_GRID_FILTERED,
                TexelKind::Stored { .. } => SHADOW_GRID,
            };
            let mut constants = kind.constants();
            constants.push(("MORE", f64::from(u8::from(has_more))));
            let pipeline = |entry_point| compute_pipeline(gpu, &shader, entry_point, &layouts, &constants);
            let [cross, keep] = ["cross", "keep"].map(pipeline);
            let grid = shadow_texture(gpu, dims);
            let columns =
                gpu.buffer("columns of light", bytes, BufferUsages::STORAGE | BufferUsages::COPY_DST);
            let light = [1.0f32, 1.0, -1.0, 0.0].repeat((bytes / 16) as usize);
            gpu.queue().write_buffer(&columns, 0, bytemuck::cast_slice(&light));
            let lights = gpu.buffer("light of slices", bytes, BufferUsages::STORAGE);
            let uniforms: Vec<wgpu::Buffer> =
                (0..slices.count()).map(|number| uniform(gpu, &[Slice::new(slices, number)])).collect();
            let numbers: Vec<usize> = (0..slices.count()).collect();
            for numbers in numbers.chunks(SLICES) {
                let mut encoder =
                    gpu.device().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
                let mut pass = gpu.pass(&mut encoder);
                pass.set_bind_group(0, scene, &[]);
                for &number in numbers {
                    let together = Together::new(slices, number);
                    let others = uniform(gpu, &together.slices);
                    let group = self.bind(gpu, [&uniforms[number], &columns, &lights, &others], &grid);
                    pass.set_bind_group(1, &group, &[]);
                    let [rows, length] = slices.size().map(|side| side as u32);
                    pass.set_pipeline(&cross);
                    pass.dispatch_workgroups((length + 1).div_ceil(GROUP), (rows + 1).div_ceil(GROUP), 1);
                    if let Some(rows) = together.rows(rows) {
                        pass.set_pipeline(&keep);
                        pass.dispatch_workgroups(length.div_ceil(GROUP), rows.div_ceil(GROUP), 1);
                    }
                }
                drop(pass);
                gpu.enqueue([encoder.finish()]);
            }
            grid
        })
    }

    fn bind(
        &self,
        gpu: &Gpu,
        [slice, columns, lights, together]: [&wgpu::Buffer; 4],
        grid: &wgpu::Texture,
    ) -> wgpu::BindGroup {
        let view = grid.create_view(&wgpu::TextureViewDescriptor::default());
        let resources = [
            slice.as_entire_binding(),
            columns.as_entire_binding(),
            lights.as_entire_binding(),
            wgpu::BindingResource::TextureView(&view),
            together.as_entire_binding(),
        ];
        bind_group(gpu, "shadow grid", &self.layout, &resources)
    }
}

/// Slices whose voxels share texels with those of one slice.
struct Together {
    slices: [Slice; LAYERS],
    is_across_z: bool,
    /// Whether all of them have been crossed.
    is_complete: bool,
}

impl Together {
    fn new(slices: &LightSlices, number: usize) -> Self {
        let this = slices.voxel(number);
        let is_across_z = slices.axes[0] == 2;
        let first = this - this % LAYERS;
        let last = (first + LAYERS).min(slices.count()) - 1;
        // Light comes to one end of the slices first.
        let is_complete = !is_across_z || number == slices.voxel(first).max(slices.voxel(last));
        let of = |c: usize| match is_across_z {
            true => Slice::new(slices, slices.voxel((first + c).min(last))),
            false => Slice::new(slices, number),
        };
        Self { slices: std::array::from_fn(of), is_across_z, is_complete }
    }

    /// Rows of texels to keep now, of a slice with `rows` rows of voxels; `None` if slices are missing.
    fn rows(&self, rows: u32) -> Option<u32> {
        let kept = if self.is_across_z { rows } else { rows.div_ceil(LAYERS as u32) };
        self.is_complete.then_some(kept)
    }
}

fn uniform(gpu: &Gpu, slices: &[Slice]) -> wgpu::Buffer {
    let bytes: &[u8] = bytemuck::cast_slice(slices);
    let buffer = gpu.buffer("slice", bytes.len() as u64, BufferUsages::UNIFORM | BufferUsages::COPY_DST);
    gpu.queue().write_buffer(&buffer, 0, bytes);
    buffer
}

/// A texture for the transmittance towards the light of a volume of `dims` voxels, four of them along z to a texel.
///
/// Like the CPU's it has 8 bits a voxel; of the formats that shaders may write and filter everywhere this is the narrowest.
pub fn shadow_texture(gpu: &Gpu, [x, y, z]: [usize; 3]) -> wgpu::Texture {
    let dims = [x, y, z.div_ceil(LAYERS)];
    texture(gpu, "shadow grid", dims, TextureFormat::Rgba8Unorm, TextureUsages::STORAGE_BINDING)
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovol_gpu::assert_twins;

    #[test]
    fn shaders_read_the_same_struct() {
        assert_twins!(
            SHADOW_GRID,
            "Slice",
            Slice { whole, part, first, columns, size, voxel, deep, down, along, steps, near }
        );
    }
}
