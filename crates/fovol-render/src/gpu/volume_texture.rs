use super::error::Result;
use super::texture::{check_dims, texture, write_slices};
use crate::Filtering;
use crate::scene::{BrickData, BrickLayout, Bricks, MaybeNan};
use bytemuck::Pod;
use fovol_gpu::Gpu;
use rayon::prelude::*;
use wgpu::{Features, TextureFormat, TextureUsages};

/// Bytes that are staged at a time: the host never holds a second copy of a large volume.
const SLAB: usize = 32 << 20;
/// Up to this many bytes texels hold their neighbours too, which takes four times the memory.
const CORNERS: usize = 256 << 20;

/// How the texels of a volume become values.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum TexelKind {
    /// Shaders interpolate stored values; see shaders/field.wgsl.
    Stored {
        /// Whether a texel holds its neighbours along y and z too.
        corners: bool,
        /// Whether texels are the bits of an f32.
        floats: bool,
    },
    /// Samplers do; see shaders/field_filtered.wgsl.
    Filtered,
}

/// The voxels of a volume in a 3-D texture, at the type that [`Bricks`] found narrowest.
///
/// In small volumes that shaders interpolate, each texel also holds its neighbours along y and z, like
/// [`BrickData::Corners`]. A sample then takes two loads instead of eight.
#[derive(Debug)]
pub struct VolumeTexture {
    texture: wgpu::Texture,
    kind: TexelKind,
    /// The factor from texels to display values.
    value_scale: f32,
}

impl VolumeTexture {
    /// The texture of `bricks`, for samplers to filter if that is `wanted` and the device can.
    ///
    /// # Errors
    /// A volume with more voxels along an axis than the device's textures have texels; a device out of memory.
    pub fn new(gpu: &Gpu, bricks: &Bricks, wanted: Filtering) -> Result<Self> {
        let filtered = (wanted == Filtering::Hardware).then(|| filtered(gpu, bricks.data())).flatten();
        match filtered {
            Some((format, unit)) => Self::with_texels(gpu, bricks, (TexelKind::Filtered, format, unit)),
            None => {
                let (corners, floats) = stored(bricks);
                let kind = TexelKind::Stored { corners, floats };
                Self::with_texels(gpu, bricks, (kind, format(bricks.data(), corners), 1.0))
            }
        }
    }

    /// The texture of `bricks` whose texels are single voxels.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn of_voxels(gpu: &Gpu, bricks: &Bricks) -> Result<Self> {
        let kind = TexelKind::Stored { corners: false, floats: stored(bricks).1 };
        Self::with_texels(gpu, bricks, (kind, format(bricks.data(), false), 1.0))
    }

    fn with_texels(
        gpu: &Gpu,
        bricks: &Bricks,
        (kind, format, unit): (TexelKind, TextureFormat, f32),
    ) -> Result<Self> {
        let layout = bricks.layout();
        check_dims(gpu, layout.dims)?;
        let texture = gpu.guarded("making room for the volume", || {
            texture(gpu, "volume", layout.dims, format, TextureUsages::COPY_DST)
        })?;
        let corners = matches!(kind, TexelKind::Stored { corners: true, .. });
        gpu.guarded("uploading the volume", || match bricks.data() {
            BrickData::Corners(words) if corners => {
                upload(gpu, &texture, layout.dims, |voxel| words[layout.index(voxel)]);
            }
            // The voxel itself is the lowest byte.
            BrickData::Corners(words) => {
                upload(gpu, &texture, layout.dims, |voxel| words[layout.index(voxel)] as u8);
            }
            BrickData::U8(values) => upload_voxels(gpu, &texture, layout, |at| values[at], corners),
            BrickData::U16(values) => upload_voxels(gpu, &texture, layout, |at| values[at], corners),
            BrickData::F32(values) => upload_voxels(gpu, &texture, layout, |at| values[at], corners),
            BrickData::Gaps(values) => upload_voxels(gpu, &texture, layout, |at| finite(values[at]), corners),
        })?;
        Ok(Self { texture, kind, value_scale: bricks.scale() * unit })
    }

    /// The factor from texels to display values.
    pub fn value_scale(&self) -> f32 {
        self.value_scale
    }

    /// The kind of the texels.
    pub fn kind(&self) -> TexelKind {
        self.kind
    }

    /// The texture.
    pub fn texture(&self) -> &wgpu::Texture {
        &self.texture
    }
}

/// Red, green and blue of voxels in a 3-D texture: bytes if all are, else the bits of f32.
#[derive(Debug)]
pub struct ColourTexture {
    texture: wgpu::Texture,
    are_floats: bool,
    scale: [f32; 3],
}

impl ColourTexture {
    /// The texture of `colours`, which have the same layout if they are bytes.
    ///
    /// # Errors
    /// As [`VolumeTexture::new`].
    pub fn new(gpu: &Gpu, colours: &[Bricks; 3]) -> Result<Self> {
        let dims = colours[0].layout().dims;
        check_dims(gpu, dims)?;
        let are_floats = !colours.iter().all(is_of_bytes);
        let format = if are_floats { TextureFormat::Rgba32Uint } else { TextureFormat::Rgba8Uint };
        let texture = gpu.guarded("making room for the colours", || {
            texture(gpu, "colours", dims, format, TextureUsages::COPY_DST)
        })?;
        gpu.guarded("uploading the colours", || {
            if are_floats {
                upload(gpu, &texture, dims, |voxel| {
                    let [r, g, b] = colours.each_ref().map(|channel| shown(channel.voxel(voxel)).to_bits());
                    [r, g, b, 0]
                });
            } else {
                upload(gpu, &texture, dims, |voxel| {
                    let [r, g, b] = colours.each_ref().map(|channel| channel.stored_voxel(voxel) as u8);
                    [r, g, b, 0]
                });
            }
        })?;
        let scale = if are_floats { [1.0; 3] } else { colours.each_ref().map(Bricks::scale) };
        Ok(Self { texture, are_floats, scale })
    }

    /// The texture.
    pub fn texture(&self) -> &wgpu::Texture {
        &self.texture
    }

    /// Whether texels are the bits of f32.
    pub fn are_floats(&self) -> bool {
        self.are_floats
    }

    /// The factors from texels to 0…1.
    pub fn scale(&self) -> [f32; 3] {
        self.scale
    }
}

fn is_of_bytes(bricks: &Bricks) -> bool {
    matches!(bricks.data(), BrickData::Corners(_) | BrickData::U8(_))
}

/// A colour that is NaN is shown at its brightest, as the CPU shows it.
fn shown(channel: f32) -> f32 {
    if channel.is_nan() { 1.0 } else { channel }
}

/// The format at which samplers of the device filter `data`, and the stored value that a texel of 1 stands for.
fn filtered(gpu: &Gpu, data: &BrickData) -> Option<(TextureFormat, f32)> {
    let has = |feature: Features| gpu.device().features().contains(feature);
    match data {
        BrickData::Corners(_) | BrickData::U8(_) => Some((TextureFormat::R8Unorm, 255.0)),
        BrickData::U16(_) => {
            has(Features::TEXTURE_FORMAT_16BIT_NORM).then_some((TextureFormat::R16Unorm, 65535.0))
        }
        BrickData::F32(_) | BrickData::Gaps(_) => {
            has(Features::FLOAT32_FILTERABLE).then_some((TextureFormat::R32Float, 1.0))
        }
    }
}

/// Whether texels that shaders interpolate hold their neighbours, and whether they are floats.
fn stored(bricks: &Bricks) -> (bool, bool) {
    let voxels: usize = bricks.layout().dims.iter().product();
    match bricks.data() {
        BrickData::Corners(_) => (true, false),
        BrickData::U8(_) => (4 * voxels <= CORNERS, false),
        BrickData::U16(_) => (8 * voxels <= CORNERS, false),
        BrickData::F32(_) | BrickData::Gaps(_) => (16 * voxels <= CORNERS, true),
    }
}

fn format(data: &BrickData, corners: bool) -> TextureFormat {
    match (data, corners) {
        (BrickData::Corners(_) | BrickData::U8(_), true) => TextureFormat::Rgba8Uint,
        (BrickData::U16(_), true) => TextureFormat::Rgba16Uint,
        (BrickData::F32(_) | BrickData::Gaps(_), true) => TextureFormat::Rgba32Uint,
        (BrickData::Corners(_) | BrickData::U8(_), false) => TextureFormat::R8Uint,
        (BrickData::U16(_), false) => TextureFormat::R16Uint,
        (BrickData::F32(_) | BrickData::Gaps(_), false) => TextureFormat::R32Uint,
    }
}

/// Stands for NaN in textures, as shaders need not support NaN. Interpolation with it always gives a negative value.
const NAN: f32 = -1e30;

fn finite(MaybeNan(value): MaybeNan) -> f32 {
    if value.is_nan() { NAN } else { value }
}

/// Writes the voxels whose stored `value` lies at each place of `layout`, alone or with their neighbours.
fn upload_voxels<T: Pod + Send + Sync>(
    gpu: &Gpu,
    texture: &wgpu::Texture,
    layout: &BrickLayout,
    value: impl Fn(usize) -> T + Sync,
    corners: bool,
) {
    let [_, uy, uz] = layout.unit;
    if corners {
        // Bricks store the neighbours of all their voxels, at the edge of the volume the last one again.
        upload(gpu, texture, layout.dims, |voxel| {
            [0, uy, uz, uy + uz].map(|after| value(layout.index(voxel) + after))
        });
    } else {
        upload(gpu, texture, layout.dims, |voxel| value(layout.index(voxel)));
    }
}

/// Writes the texels of all voxels to `texture`, some slices at a time.
fn upload<T: Pod + Send>(
    gpu: &Gpu,
    texture: &wgpu::Texture,
    [nx, ny, nz]: [usize; 3],
    texel: impl Fn([usize; 3]) -> T + Sync,
) {
    let slices = (SLAB / (nx * ny * size_of::<T>())).max(1);
    let mut slab = vec![T::zeroed(); nx * ny * slices.min(nz)];
    for first in (0..nz).step_by(slices) {
        let slab = &mut slab[..nx * ny * slices.min(nz - first)];
        slab.par_chunks_mut(nx).enumerate().for_each(|(row, texels)| {
            for (x, out) in texels.iter_mut().enumerate() {
                *out = texel([x, row % ny, first + row / ny]);
            }
        });
        write_slices(gpu, texture, first, bytemuck::cast_slice(slab));
        // Staging memory is freed once a submission has used it.
        gpu.enqueue([]);
    }
}
