use super::device::Gpu;
use super::error::Result;
use super::texture::{check_dims, texture, write_slices};
use crate::cpu::{BrickData, BrickLayout, Bricks};
use bytemuck::Pod;
use rayon::prelude::*;
use wgpu::{TextureFormat, TextureUsages};

/// Bytes that are staged at a time: the host never holds a second copy of a large volume.
const SLAB: usize = 32 << 20;

/// How the texels of a volume become values; see shaders/field.wgsl.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct TexelKind {
    /// Whether a texel holds its neighbours along y and z too.
    pub corners: bool,
    /// Whether texels are the bits of an f32.
    pub floats: bool,
}

/// The voxels of a volume in a 3-D texture, at the type that [`Bricks`] found narrowest.
///
/// Small 8-bit volumes have their neighbours along y and z in each texel, like [`BrickData::Corners`]: two loads a sample
/// instead of eight.
#[derive(Debug)]
pub struct VolumeTexture {
    texture: wgpu::Texture,
    kind: TexelKind,
}

impl VolumeTexture {
    /// The texture of `bricks`.
    ///
    /// # Errors
    /// A volume with more voxels along an axis than the device's textures have texels; a device out of memory.
    pub fn new(gpu: &Gpu, bricks: &Bricks) -> Result<Self> {
        let dims = bricks.layout().dims;
        check_dims(gpu, dims)?;
        let (format, corners, floats) = match bricks.data() {
            BrickData::Corners(_) => (TextureFormat::Rgba8Uint, true, false),
            BrickData::U8(_) => (TextureFormat::R8Uint, false, false),
            BrickData::U16(_) => (TextureFormat::R16Uint, false, false),
            BrickData::F32(_) => (TextureFormat::R32Uint, false, true),
        };
        let texture = gpu.guarded("making room for the volume", || {
            texture(gpu, "volume", dims, format, TextureUsages::COPY_DST)
        })?;
        gpu.guarded("uploading the volume", || match bricks.data() {
            BrickData::Corners(values) => upload(gpu, &texture, bricks.layout(), values),
            BrickData::U8(values) => upload(gpu, &texture, bricks.layout(), values),
            BrickData::U16(values) => upload(gpu, &texture, bricks.layout(), values),
            BrickData::F32(values) => upload(gpu, &texture, bricks.layout(), values),
        })?;
        Ok(Self { texture, kind: TexelKind { corners, floats } })
    }

    /// What its texels are.
    pub fn kind(&self) -> TexelKind {
        self.kind
    }

    /// The texture.
    pub fn texture(&self) -> &wgpu::Texture {
        &self.texture
    }
}

/// Writes stored `values` to `texture`, some slices at a time.
fn upload<T: Pod + Send + Sync>(gpu: &Gpu, texture: &wgpu::Texture, layout: &BrickLayout, values: &[T]) {
    let [nx, ny, nz] = layout.dims;
    let slices = (SLAB / (nx * ny * size_of::<T>())).max(1);
    let mut slab = vec![T::zeroed(); nx * ny * slices.min(nz)];
    for first in (0..nz).step_by(slices) {
        let slab = &mut slab[..nx * ny * slices.min(nz - first)];
        slab.par_chunks_mut(nx).enumerate().for_each(|(row, texels)| {
            for (x, texel) in texels.iter_mut().enumerate() {
                *texel = values[layout.index([x, row % ny, first + row / ny])];
            }
        });
        write_slices(gpu, texture, first, bytemuck::cast_slice(slab));
        // What is staged is freed as soon as a submission has used it.
        gpu.queue().submit([]);
    }
}
