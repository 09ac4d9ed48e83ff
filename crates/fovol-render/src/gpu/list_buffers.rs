use bytemuck::{Pod, Zeroable};
use fovol_gpu::Gpu;
use wgpu::BufferUsages;

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

    /// Workgroups of a dispatch over the list.
    pub fn groups(&self) -> [u32; 3] {
        [self.groups_x, self.groups_y, self.groups_z]
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

const STORAGE: BufferUsages =
    BufferUsages::STORAGE.union(BufferUsages::COPY_DST).union(BufferUsages::COPY_SRC);

impl Shaded {
    /// Room for the results of `pixels` rays, with `bytes` for what goes with the inverse depth.
    pub fn new(gpu: &Gpu, labels: [&str; 2], pixels: u64, bytes: u64) -> Self {
        Self {
            colours: gpu.buffer(labels[0], 16 * pixels, STORAGE),
            inverse_depths: gpu.buffer(labels[1], bytes * pixels, STORAGE),
        }
    }
}

/// A list of pixels on the device, and the results of their rays in its order.
#[derive(Debug)]
pub struct ListBuffers {
    pub(super) length: wgpu::Buffer,
    pub(super) pixels: wgpu::Buffer,
    pub(super) results: Shaded,
}

impl ListBuffers {
    /// Room for `most` pixels.
    pub(super) fn new(gpu: &Gpu, most: u64) -> Self {
        Self {
            length: gpu.buffer(
                "list length",
                size_of::<ListLength>() as u64,
                STORAGE | BufferUsages::INDIRECT,
            ),
            pixels: gpu.buffer("list", 4 * most, STORAGE),
            results: Shaded::new(gpu, ["sample colours", "sample depths"], most, 16),
        }
    }

    /// The number of pixels: the first u32. The workgroups of an indirect dispatch follow, see [`Self::GROUPS_OFFSET`].
    pub fn length(&self) -> &wgpu::Buffer {
        &self.length
    }

    /// Where the workgroups of an indirect dispatch of 64 threads each stand in [`Self::length`], in bytes.
    pub const GROUPS_OFFSET: u64 = GROUPS_OFFSET;

    /// The workgroups along x, y and z of 64 threads each for a list of at most `most` pixels. Thread t of group (x, y) has
    /// the pixel (1024·y + x)·64 + t.
    pub fn groups(most: u32) -> [u32; 3] {
        ListLength::of(most).groups()
    }

    /// The pixels: u32 with x in the low and y in the high half.
    pub fn pixels(&self) -> &wgpu::Buffer {
        &self.pixels
    }

    /// For each pixel red, green and blue over the background, and opacity; f32.
    pub fn colours(&self) -> &wgpu::Buffer {
        &self.results.colours
    }

    /// For each pixel the inverse depth in 1 over world units, and red, green and blue without shadows before the
    /// background; f32.
    pub fn unshadowed(&self) -> &wgpu::Buffer {
        &self.results.inverse_depths
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::shader::{COMPACT, MARCH, MASK, SCATTER};
    use fovol_gpu::assert_twins;

    #[test]
    fn shaders_read_the_same_struct() {
        for shader in [MASK, COMPACT, MARCH, SCATTER] {
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
