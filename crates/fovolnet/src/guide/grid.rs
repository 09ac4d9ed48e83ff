use fovol_core::{FrameSize, Pixel, Region, SampleList};

/// Pixels of the guide of one frame: every `step`-th column and row from `phase` on, within `region`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct GuideGrid {
    /// Region in which the scene can be seen. Outside it the guide is 0.
    pub region: Region,
    /// Distance between the pixels: 1 or 2.
    pub step: u32,
    /// First column and row of the frame's grid, below `step`.
    phase: [u32; 2],
    frame: FrameSize,
}

/// First column and row of a grid of every second pixel, in frames that follow each other. Four frames see every pixel.
const PHASES: [[u32; 2]; 4] = [[1, 1], [0, 0], [1, 0], [0, 1]];

impl GuideGrid {
    /// Grid of frame number `index`, of size `frame`, with every pixel (`step` 1) or every second column and row
    /// (`step` 2) of `region`.
    pub fn new(step: u32, index: u32, region: Region, frame: FrameSize) -> Self {
        let phase = if step == 1 { [0, 0] } else { PHASES[index as usize % PHASES.len()] };
        Self { region, step, phase, frame }
    }

    /// Size of the frame.
    pub fn frame_size(&self) -> FrameSize {
        self.frame
    }

    /// Numbers of the first grid column and row in the region, and the number of columns and rows.
    fn extent(&self) -> [[u32; 2]; 2] {
        let along = |first: u32, length: u32, phase: u32| {
            let begin = first.saturating_sub(phase).div_ceil(self.step);
            let end = (first + length).saturating_sub(phase).div_ceil(self.step);
            [begin, end - begin]
        };
        let Region { x, y, size } = self.region;
        let ([x, columns], [y, rows]) =
            (along(x, size.width, self.phase[0]), along(y, size.height, self.phase[1]));
        [[x, y], [columns, rows]]
    }

    /// Number of columns and rows of the grid.
    pub fn size(&self) -> [usize; 2] {
        let [_, size] = self.extent();
        size.map(|count| count as usize)
    }

    /// Column and row of the frame that the first pixel of the grid has.
    pub fn first(&self) -> [u32; 2] {
        let [first, _] = self.extent();
        [0, 1].map(|axis| first[axis] * self.step + self.phase[axis])
    }

    /// Pixels of the grid, row by row.
    pub fn list(&self) -> SampleList {
        let ([x0, y0], [columns, rows]) = (self.first(), self.size());
        let along = |first: u32, count: usize| (0..count).map(move |i| (first + i as u32 * self.step) as u16);
        let pixels = along(y0, rows).flat_map(|y| along(x0, columns).map(move |x| Pixel { x, y }));
        SampleList::new(self.frame, pixels.collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn four_frames_see_every_pixel_of_the_region_once(
            (x, y) in (0u32..20, 0u32..20),
            (width, height) in (1u32..20, 1u32..20),
            first in 0u32..9,
        ) {
            let frame = FrameSize { width: 40, height: 40 };
            let region = Region { x, y, size: FrameSize { width, height } };
            let mut seen = Vec::new();
            for index in first..first + 4 {
                let grid = GuideGrid::new(2, index, region, frame);
                let [columns, rows] = grid.size();
                prop_assert_eq!(grid.list().len(), columns * rows);
                seen.extend_from_slice(grid.list().pixels());
            }
            seen.sort_by_key(|pixel| (pixel.y, pixel.x));
            let all = GuideGrid::new(1, first, region, frame).list();
            prop_assert_eq!(seen, all.pixels());
        }
    }
}
