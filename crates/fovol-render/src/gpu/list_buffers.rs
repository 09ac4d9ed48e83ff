use bytemuck::{Pod, Zeroable};
use fovol_gpu::Gpu;
use wgpu::BufferUsages;

/// The length of a list, and the workgroups of dispatches over it. Twin of `ListLength` in shaders/frame.wgsl.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct ListLength {
    pub pixels: u32,
    /// Along x, y and z for each of [`GroupSize::ALL`].
    groups: [u32; 12],
}

/// Pixels of a list that one workgroup has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum GroupSize {
    SixtyFour,
    Sixteen,
    Four,
    One,
}

impl GroupSize {
    /// All of them, as they stand in a [`ListLength`].
    pub const ALL: [Self; 4] = [Self::SixtyFour, Self::Sixteen, Self::Four, Self::One];

    /// The size of `pixels`, if there is one.
    pub fn of(pixels: u32) -> Option<Self> {
        Self::ALL.into_iter().find(|size| size.pixels() == pixels)
    }

    /// Number of pixels.
    pub fn pixels(self) -> u32 {
        64 >> (2 * self as u32)
    }

    /// Where the workgroups stand in a [`ListLength`], bytes.
    pub fn offset(self) -> u64 {
        4 + 12 * self as u64
    }

    /// Workgroups along x, y and z over a list of `pixels`.
    pub fn groups(self, pixels: u32) -> [u32; 3] {
        let groups = pixels.div_ceil(self.pixels());
        [groups.min(GROUPS_X), groups.div_ceil(GROUPS_X), 1]
    }
}

/// Workgroups over a list along x; as in shaders/frame.wgsl.
const GROUPS_X: u32 = 1024;

impl ListLength {
    /// The length of a list of `pixels`.
    pub fn of(pixels: u32) -> Self {
        let groups = GroupSize::ALL.map(|size| size.groups(pixels));
        Self { pixels, groups: bytemuck::cast(groups) }
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
    /// Room for the results of `most` samples.
    pub fn of_samples(gpu: &Gpu, most: u64) -> Self {
        Self::new(gpu, ["sample colours", "sample depths"], most, 16)
    }

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
            results: Shaded::of_samples(gpu, most),
        }
    }

    /// The number of pixels: the first u32. The workgroups of an indirect dispatch follow, see [`Self::GROUPS_OFFSET`].
    pub fn length(&self) -> &wgpu::Buffer {
        &self.length
    }

    /// Where the workgroups of an indirect dispatch of 64 threads each stand in [`Self::length`], in bytes.
    pub const GROUPS_OFFSET: u64 = 4;

    /// The workgroups along x, y and z of 64 threads each for a list of at most `most` pixels. Thread t of group (x, y) has
    /// the pixel (1024·y + x)·64 + t.
    pub fn groups(most: u32) -> [u32; 3] {
        GroupSize::SixtyFour.groups(most)
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
            assert_twins!(shader, "ListLength", ListLength { pixels, groups });
        }
    }

    #[test]
    fn dispatches_have_a_thread_for_each_pixel_of_the_list() {
        for pixels in [0, 1, 64, 65, 65_536, 65_537, 10_000_000] {
            for size in GroupSize::ALL {
                let [x, y, z] = size.groups(pixels);
                assert!(x * y * z * size.pixels() >= pixels && x <= GROUPS_X, "{pixels} {size:?}");
                assert!(pixels > 0 || x * y == 0);
                let at = (size.offset() as usize - 4) / 4;
                assert_eq!(ListLength::of(pixels).groups[at..at + 3], [x, y, z]);
                assert_eq!(GroupSize::of(size.pixels()), Some(size));
            }
        }
    }
}
