use super::list_buffers::{ListBuffers, Shaded};
use super::mask_limits::MaskSettings;
use super::texture::texture;
use super::view::View;
use crate::noise::NoiseSize;
use bytemuck::{Pod, Zeroable};
use fovol_core::FrameSize;
use fovol_gpu::Gpu;
use wgpu::{BufferUsages, TextureFormat, TextureUsages};

/// Words of one block; as in shaders/inclusive_sum.wgsl.
pub const BLOCK: u32 = 256;

/// Rows of a tile of words; as in shaders/compact.wgsl.
const TILE_ROWS: u32 = 32;

/// How many blocks of words the tiles of a mask of `size` have.
pub fn blocks(size: FrameSize) -> u32 {
    (size.width.div_ceil(64) * 2 * size.height.next_multiple_of(TILE_ROWS)).div_ceil(BLOCK)
}

/// Width and height, as shaders read them. Twin of `Extent` in shaders/frame.wgsl.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct Extent {
    pub width: u32,
    pub height: u32,
}

/// The memory of one frame.
#[derive(Debug)]
pub struct Buffers {
    /// Number of pixels of the frame.
    pub pixels: usize,
    pub extent: wgpu::Buffer,
    pub view: wgpu::Buffer,
    pub mask_settings: wgpu::Buffer,
    /// The noise of the frame, where it is a tile.
    pub tile: wgpu::Buffer,
    /// Noise of the frame, where it places few shadow rays.
    pub noise: wgpu::Texture,
    /// See [`Limits`]; grows with the fovea.
    pub limits: wgpu::Buffer,
    pub mask: wgpu::Buffer,
    pub blocks: wgpu::Buffer,
    /// The samples.
    pub listed: ListBuffers,
    /// Row by row.
    pub frame: Shaded,
}

impl Buffers {
    pub fn new(gpu: &Gpu, size: FrameSize) -> Self {
        let storage = BufferUsages::STORAGE | BufferUsages::COPY_DST | BufferUsages::COPY_SRC;
        let uniform = BufferUsages::UNIFORM | BufferUsages::COPY_DST;
        let pixels = size.pixels() as u64;
        let words = u64::from(size.width.div_ceil(64) * 2) * u64::from(size.height);
        Self {
            pixels: size.pixels(),
            extent: gpu.buffer("extent", size_of::<Extent>() as u64, uniform),
            view: gpu.buffer("view", size_of::<View>() as u64, uniform),
            mask_settings: gpu.buffer("mask settings", size_of::<MaskSettings>() as u64, uniform),
            tile: gpu.buffer("noise", 4 * NoiseSize::STBN.frame_len() as u64, storage),
            noise: noise_texture(gpu),
            limits: gpu.buffer("limits", 4, storage),
            mask: gpu.buffer("mask", 4 * words, storage),
            blocks: gpu.buffer("blocks", 4 * u64::from(blocks(size)), storage),
            listed: ListBuffers::new(gpu, pixels),
            frame: Shaded::new(gpu, ["frame", "frame depths"], pixels, 4),
        }
    }
}

/// Room for the ranks of a tile of noise.
fn noise_texture(gpu: &Gpu) -> wgpu::Texture {
    let edge = NoiseSize::STBN.frame_len().isqrt();
    texture(gpu, "noise of shadow rays", [edge, edge, 1], TextureFormat::R32Uint, TextureUsages::COPY_DST)
}

/// The bind groups of [`Buffers`], one for each step.
#[derive(Debug)]
pub struct Groups {
    pub mask: wgpu::BindGroup,
    pub compact: wgpu::BindGroup,
    /// For marching a list.
    pub march_list: wgpu::BindGroup,
    /// For marching a full frame.
    pub march_frame: wgpu::BindGroup,
    pub scatter: wgpu::BindGroup,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::shader::{COMPACT, MARCH, MASK, SCATTER};
    use fovol_gpu::assert_twins;

    #[test]
    fn shaders_read_the_same_struct() {
        for shader in [MASK, COMPACT, MARCH, SCATTER] {
            assert_twins!(shader, "Extent", Extent { width, height });
        }
    }
}
