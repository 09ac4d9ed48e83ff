use super::mask_limits::MaskSettings;
use super::view::View;
use crate::noise::NoiseSize;
use bytemuck::{Pod, Zeroable};
use fovol_core::FrameSize;
use fovol_gpu::Gpu;
use wgpu::BufferUsages;

/// Words of one block; as in shaders/compact.wgsl.
pub const BLOCK: u32 = 256;

/// How many blocks of words the mask of a frame of `size` has.
pub fn blocks(size: FrameSize) -> u32 {
    (size.width.div_ceil(64) * 2 * size.height).div_ceil(BLOCK)
}

/// Width and height, as shaders read them. Twin of `Extent` in shaders/frame.wgsl.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct Extent {
    pub width: u32,
    pub height: u32,
}

/// The length of a list, and the workgroups of a dispatch over it. Twin of `ListLength` in shaders/frame.wgsl.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct ListLength {
    pub pixels: u32,
    groups_x: u32,
    groups_y: u32,
    groups_z: u32,
}

/// Where the workgroups stand in a [`ListLength`], bytes.
pub const GROUPS_OFFSET: u64 = 4;
/// Threads of a workgroup over a list; as in shaders/frame.wgsl.
const LIST_GROUP: u32 = 64;
/// Workgroups over a list along x; as in shaders/frame.wgsl.
const GROUPS_X: u32 = 1024;

impl ListLength {
    /// The length of a list of `pixels`.
    pub fn of(pixels: u32) -> Self {
        let groups = pixels.div_ceil(LIST_GROUP);
        Self { pixels, groups_x: groups.min(GROUPS_X), groups_y: groups.div_ceil(GROUPS_X), groups_z: 1 }
    }
}

/// Results of the rays of pixels or of samples.
#[derive(Debug)]
pub struct Shaded {
    /// 16 bytes each.
    pub colours: wgpu::Buffer,
    /// 4 bytes for a pixel. 16 for a sample: its colour without shadows follows.
    pub inverse_depths: wgpu::Buffer,
}

/// The memory of one frame.
#[derive(Debug)]
pub struct Buffers {
    pub extent: wgpu::Buffer,
    pub view: wgpu::Buffer,
    pub mask_settings: wgpu::Buffer,
    /// The noise of the frame, where it is a tile.
    pub tile: wgpu::Buffer,
    /// See [`Limits`]; grows with the fovea.
    pub limits: wgpu::Buffer,
    pub mask: wgpu::Buffer,
    pub blocks: wgpu::Buffer,
    pub list_length: wgpu::Buffer,
    pub list: wgpu::Buffer,
    /// In the order of the list.
    pub samples: Shaded,
    /// Row by row.
    pub frame: Shaded,
}

impl Buffers {
    pub fn new(gpu: &Gpu, size: FrameSize) -> Self {
        let storage = BufferUsages::STORAGE | BufferUsages::COPY_DST | BufferUsages::COPY_SRC;
        let uniform = BufferUsages::UNIFORM | BufferUsages::COPY_DST;
        let pixels = size.pixels() as u64;
        let shaded = |what: [&str; 2], bytes: u64| Shaded {
            colours: gpu.buffer(what[0], 16 * pixels, storage),
            inverse_depths: gpu.buffer(what[1], bytes * pixels, storage),
        };
        let words = u64::from(size.width.div_ceil(64) * 2) * u64::from(size.height);
        Self {
            extent: gpu.buffer("extent", size_of::<Extent>() as u64, uniform),
            view: gpu.buffer("view", size_of::<View>() as u64, uniform),
            mask_settings: gpu.buffer("mask settings", size_of::<MaskSettings>() as u64, uniform),
            tile: gpu.buffer("noise", 4 * NoiseSize::STBN.frame_len() as u64, storage),
            limits: gpu.buffer("limits", 4, storage),
            mask: gpu.buffer("mask", 4 * words, storage),
            blocks: gpu.buffer("blocks", 4 * u64::from(blocks(size)), storage),
            list_length: gpu.buffer(
                "list length",
                size_of::<ListLength>() as u64,
                storage | BufferUsages::INDIRECT,
            ),
            list: gpu.buffer("list", 4 * pixels, storage),
            samples: shaded(["sample colours", "sample depths"], 16),
            frame: shaded(["frame", "frame depths"], 4),
        }
    }
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
    fn shaders_read_the_same_structs() {
        for shader in [MASK, COMPACT, MARCH, SCATTER] {
            assert_twins!(shader, "Extent", Extent { width, height });
            assert_twins!(shader, "ListLength", ListLength { pixels, groups_x, groups_y, groups_z });
        }
    }

    #[test]
    fn dispatches_have_a_thread_for_each_pixel_of_the_list() {
        for pixels in [0, 1, 64, 65, 65_536, 65_537, 10_000_000] {
            let length = ListLength::of(pixels);
            let groups = length.groups_x * length.groups_y;
            assert!(groups * LIST_GROUP >= pixels && length.groups_x <= GROUPS_X, "{length:?}");
            assert!(pixels > 0 || groups == 0);
        }
    }
}
