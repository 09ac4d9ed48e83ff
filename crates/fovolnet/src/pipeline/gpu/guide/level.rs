use crate::guide::GuideGrid;
use bytemuck::{Pod, Zeroable};

/// Level of a guide and the coarser one before it, as shaders read them. Twin of `Level` in shaders/guide_level.wgsl.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct Level {
    region_from: [u32; 2],
    region_size: [u32; 2],
    first: [u32; 2],
    size: [u32; 2],
    coarse_first: [u32; 2],
    coarse_size: [u32; 2],
    repeats_before: [u32; 2],
    repeats_after: [u32; 2],
    width: u32,
    step: u32,
    least: u32,
    most: u32,
}

impl Level {
    /// `grid`, whose pixels are all marched.
    pub fn coarsest(grid: &GuideGrid) -> Self {
        Self::finer(grid, grid, (0, 0))
    }

    /// `grid` between the pixels of `coarse`. Pixels are marched whose contrast in bytes is at least `least`, until `most`
    /// pixels are known.
    pub fn finer(coarse: &GuideGrid, grid: &GuideGrid, (least, most): (u32, u32)) -> Self {
        let (region, frame) = (grid.region, grid.frame_size());
        let [columns, rows] = grid.size();
        let [coarse_columns, coarse_rows] = coarse.size();
        let begins = [region.x, region.y].map(|begin| u32::from(begin == 0));
        let ends =
            [region.x + region.size.width == frame.width, region.y + region.size.height == frame.height];
        Self {
            region_from: [region.x, region.y],
            region_size: [region.size.width, region.size.height],
            first: grid.first(),
            size: [columns as u32, rows as u32],
            coarse_first: coarse.first(),
            coarse_size: [coarse_columns as u32, coarse_rows as u32],
            repeats_before: begins,
            repeats_after: ends.map(u32::from),
            width: frame.width,
            step: grid.step,
            // A contrast of 0 is nothing to march.
            least: least.max(1),
            most,
        }
    }

    /// Number of pixels of the level.
    pub fn pixels(&self) -> u32 {
        self.size[0] * self.size[1]
    }

    /// Workgroups of 8×8 over the level.
    pub fn groups(&self) -> [u32; 2] {
        self.size.map(|side| side.div_ceil(8))
    }

    /// Most pixels that may be known after this level.
    pub fn most(&self) -> u32 {
        self.most
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pipeline::gpu::guide::shader::{GUIDE, PUT};
    use fovol_gpu::assert_twins;
    use wgpu::naga::valid::Capabilities;

    #[test]
    fn the_shaders_are_valid_and_read_the_same_struct() {
        for shader in [GUIDE, PUT] {
            shader.check(Capabilities::empty()).unwrap_or_else(|problem| panic!("{problem}"));
            assert_twins!(
                shader,
                "Level",
                Level {
                    region_from,
                    region_size,
                    first,
                    size,
                    coarse_first,
                    coarse_size,
                    repeats_before,
                    repeats_after,
                    width,
                    step,
                    least,
                    most
                }
            );
        }
    }
}
