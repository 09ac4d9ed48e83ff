use super::texture::{texture, write_slices};
use crate::cpu::light_columns::LightColumns;
use bytemuck::{Pod, Zeroable};
use fovol_gpu::Gpu;
use wgpu::{TextureFormat, TextureUsages};

/// Uniforms of the columns. Twin of `LightColumns` in shaders/light_columns.wgsl.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct ColumnNumbers {
    axes: [u32; 3],
    origin: f32,
    shear: [f32; 2],
    low: [f32; 2],
    last: [f32; 2],
    slabs: f32,
    density: f32,
}

impl ColumnNumbers {
    /// The numbers of `columns`; zeros where there are none.
    pub fn new(columns: Option<&LightColumns>) -> Self {
        columns.map_or_else(Self::zeroed, |columns| {
            let axes = columns.axes();
            let [across, down, _] = columns.dims();
            Self {
                axes: axes.order.map(|axis| axis as u32),
                origin: axes.origin,
                shear: axes.shear,
                low: axes.low,
                last: [across, down].map(|count| (count - 1) as f32),
                slabs: axes.slabs,
                density: 1.0 / axes.width,
            }
        })
    }
}

/// Whether a texture of the device of `gpu` holds `columns`.
pub fn fit(gpu: &Gpu, columns: &LightColumns) -> bool {
    let most = gpu.device().limits().max_texture_dimension_3d as usize;
    columns.dims().into_iter().all(|side| side <= most)
}

/// The words of `columns` on the device, or a texture that nobody reads.
pub fn words(gpu: &Gpu, columns: Option<&LightColumns>) -> wgpu::Texture {
    let dims = columns.map_or([1; 3], LightColumns::dims);
    let made = texture(gpu, "light columns", dims, TextureFormat::R32Uint, TextureUsages::COPY_DST);
    if let Some(columns) = columns {
        write_slices(gpu, &made, 0, bytemuck::cast_slice(columns.all_words()));
    }
    made
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::shader::{MARCH, POOL, SHADOW_GRID};
    use fovol_gpu::assert_twins;

    #[test]
    fn shaders_read_the_same_struct() {
        for shader in [MARCH, POOL, SHADOW_GRID] {
            assert_twins!(
                shader,
                "LightColumns",
                ColumnNumbers { axes, origin, shear, low, last, slabs, density }
            );
        }
    }
}
