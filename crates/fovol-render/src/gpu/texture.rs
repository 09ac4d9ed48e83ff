use fovol_gpu::{Gpu, GpuError, Result};
use wgpu::{TextureFormat, TextureUsages};

/// A 3-D texture to read in shaders; `usage` is added to that.
pub fn texture(
    gpu: &Gpu,
    label: &str,
    dims: [usize; 3],
    format: TextureFormat,
    usage: TextureUsages,
) -> wgpu::Texture {
    gpu.device().create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: extent(dims),
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D3,
        format,
        usage: usage | TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    })
}

/// Writes `texels`, x fastest, to the slices of `texture` from `first` on.
pub fn write_slices(gpu: &Gpu, texture: &wgpu::Texture, first: usize, texels: &[u8]) {
    let size = texture.size();
    let texel = texture.format().block_copy_size(None).unwrap_or(1);
    let slice = (texel * size.width * size.height) as usize;
    let layout = wgpu::TexelCopyBufferLayout {
        offset: 0,
        bytes_per_row: Some(texel * size.width),
        rows_per_image: Some(size.height),
    };
    let target = wgpu::TexelCopyTextureInfo {
        texture,
        mip_level: 0,
        origin: wgpu::Origin3d { x: 0, y: 0, z: first as u32 },
        aspect: wgpu::TextureAspect::All,
    };
    let written = wgpu::Extent3d { depth_or_array_layers: (texels.len() / slice) as u32, ..size };
    gpu.queue().write_texture(target, texels, layout, written);
}

/// Checks that a 3-D texture of `dims` fits the device.
///
/// # Errors
/// An edge longer than the device allows.
pub fn check_dims(gpu: &Gpu, dims: [usize; 3]) -> Result<()> {
    let longest = dims.into_iter().max().unwrap_or(0) as u64;
    GpuError::check_limit(
        format!("a volume of {}x{}x{}", dims[0], dims[1], dims[2]),
        longest,
        ("maxTextureDimension3D", gpu.device().limits().max_texture_dimension_3d.into()),
        "average its voxels with --downsample 2 (or more), or use --device cpu",
    )
}

fn extent(dims: [usize; 3]) -> wgpu::Extent3d {
    let [width, height, depth_or_array_layers] = dims.map(|d| d as u32);
    wgpu::Extent3d { width, height, depth_or_array_layers }
}
