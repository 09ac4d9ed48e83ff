use fovol_core::{FrameSize, Pixel, Region};

/// Pixels of one level of a frame's guide: every `step`-th column and row from `phase` on, within `region`.
///
/// The levels of a frame are nested: each has every pixel of the coarser ones.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct GuideGrid {
    /// Region in which the scene can be seen. Outside it the guide is 0.
    pub region: Region,
    /// Distance between the columns and between the rows: 1, 2 or 4 pixels.
    pub step: u32,
    /// First column and row of the frame's grid, below `step`.
    phase: [u32; 2],
    /// First column and row of the grid in the region, and the number of columns and rows.
    first: [u32; 2],
    size: [usize; 2],
    frame: FrameSize,
}

/// First column and row of a grid of every second pixel, in frames that follow each other. Four frames see every pixel.
const PHASES: [[u32; 2]; 4] = [[1, 1], [0, 0], [1, 0], [0, 1]];

/// Least width and height of a region whose guide begins coarse. Smaller ones are not worth the interpolation.
const LEAST_SIDE: u32 = 16;

impl GuideGrid {
    /// Every pixel of `region` in a frame of size `frame`.
    pub fn every_pixel(region: Region, frame: FrameSize) -> Self {
        Self::new(region, 1, [0, 0], frame)
    }

    /// Coarsest level of frame number `index`, of size `frame`: every fourth column and row of `region`, or every one
    /// of a small region. Sixteen frames see every pixel, and four of them every pixel of the next level.
    pub fn coarsest(index: u32, region: Region, frame: FrameSize) -> Self {
        if region.size.width.min(region.size.height) < LEAST_SIDE {
            return Self::every_pixel(region, frame);
        }
        let [fine, coarse] = [index, index / 4].map(|index| PHASES[index as usize % PHASES.len()]);
        Self::new(region, 4, [0, 1].map(|axis| fine[axis] + 2 * coarse[axis]), frame)
    }

    fn new(region: Region, step: u32, phase: [u32; 2], frame: FrameSize) -> Self {
        let Region { x, y, size } = region;
        let along = |begin: u32, length: u32, phase: u32| {
            let number = |at: u32| at.saturating_sub(phase).div_ceil(step);
            let first = number(begin);
            (first * step + phase, (number(begin + length) - first) as usize)
        };
        let ((left, columns), (top, rows)) =
            (along(x, size.width, phase[0]), along(y, size.height, phase[1]));
        Self { region, step, phase, first: [left, top], size: [columns, rows], frame }
    }

    /// Level with half the distance between its pixels; `None` if this one has every pixel.
    pub fn finer(&self) -> Option<Self> {
        let step = self.step / 2;
        (step > 0).then(|| Self::new(self.region, step, self.phase.map(|phase| phase % step), self.frame))
    }

    /// Size of the frame.
    pub fn frame_size(&self) -> FrameSize {
        self.frame
    }

    /// Number of columns and rows of the grid.
    pub fn size(&self) -> [usize; 2] {
        self.size
    }

    /// Column and row of the frame that the first pixel of the grid has.
    pub fn first(&self) -> [u32; 2] {
        self.first
    }

    /// Pixel of the frame in column `x` and row `y` of the grid.
    pub fn pixel(&self, x: usize, y: usize) -> Pixel {
        let [left, top] = self.first;
        Pixel { x: (left + x as u32 * self.step) as u16, y: (top + y as u32 * self.step) as u16 }
    }

    /// Index of `pixel` of the frame in the grid, row by row; `None` if the grid does not have it.
    pub fn index(&self, pixel: Pixel) -> Option<usize> {
        let along = |at: u16, axis: usize| {
            let way = u32::from(at).checked_sub(self.first[axis])?;
            let number = (way / self.step) as usize;
            (way.is_multiple_of(self.step) && number < self.size[axis]).then_some(number)
        };
        let (x, y) = (along(pixel.x, 0)?, along(pixel.y, 1)?);
        Some(y * self.size[0] + x)
    }

    /// Pixels of the grid, row by row.
    pub fn pixels(&self) -> Vec<Pixel> {
        let [columns, rows] = self.size;
        let row = |y| (0..columns).map(move |x| self.pixel(x, y));
        (0..rows).flat_map(row).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn levels_are_nested_and_sixteen_frames_see_every_pixel_once(
            (x, y) in (0u32..20, 0u32..20),
            (width, height) in (16u32..30, 16u32..30),
            first in 0u32..20,
        ) {
            let frame = FrameSize { width: 50, height: 50 };
            let region = Region { x, y, size: FrameSize { width, height } };
            let mut seen = [Vec::new(), Vec::new()];
            for index in first..first + 16 {
                let coarse = GuideGrid::coarsest(index, region, frame);
                let fine = coarse.finer().unwrap();
                let every = fine.finer().unwrap();
                prop_assert_eq!(every, GuideGrid::every_pixel(region, frame));
                prop_assert!(every.finer().is_none());
                let [columns, rows] = coarse.size();
                prop_assert_eq!(coarse.pixels().len(), columns * rows);
                prop_assert!(coarse.pixels().iter().all(|pixel| fine.pixels().contains(pixel)));
                for grid in [coarse, fine] {
                    let pixels = grid.pixels();
                    prop_assert!(pixels.iter().enumerate().all(|(i, pixel)| grid.index(*pixel) == Some(i)));
                    let others = every.pixels().into_iter().filter(|pixel| !pixels.contains(pixel));
                    prop_assert!(others.into_iter().all(|pixel| grid.index(pixel).is_none()));
                }
                seen[0].extend(coarse.pixels());
                seen[1].extend(fine.pixels());
            }
            let every = GuideGrid::every_pixel(region, frame).pixels();
            for (mut seen, times) in seen.into_iter().zip([1, 4]) {
                seen.sort_by_key(|pixel| (pixel.y, pixel.x));
                let repeated: Vec<Pixel> = every.iter().flat_map(|pixel| vec![*pixel; times]).collect();
                prop_assert_eq!(seen, repeated);
            }
        }
    }

    #[test]
    fn small_regions_are_marched_whole() {
        let frame = FrameSize { width: 50, height: 50 };
        let region = Region { x: 3, y: 4, size: FrameSize { width: 15, height: 40 } };
        assert_eq!(GuideGrid::coarsest(3, region, frame), GuideGrid::every_pixel(region, frame));
    }
}
