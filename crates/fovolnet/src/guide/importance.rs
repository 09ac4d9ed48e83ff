use super::{EPSILON, UpsampledGuide};
use fovol_core::{Frame, Region};
use fovol_render::Importance;
use rayon::prelude::*;

/// Exponent of squared errors in the density that makes their sum least. With errors that fall as density^−γ it is
/// 1/(1 + γ); measured, γ is 0.75 to 0.9.
const SHARE: f32 = 0.55;

/// Importance of samples in `region` for the next frame, where colours are reconstructed: the slope of `frame`.
pub fn importance_of_colours(frame: &Frame, region: Region) -> Importance {
    let luminance =
        |x: u32, y: u32| sum(frame.pixels()[y as usize * frame.size().width as usize + x as usize]);
    let slopes = Blocks::new(region, luminance).squared_slopes().map(f32::sqrt);
    Importance::new(region, slopes.cells())
}

/// Importance of samples in the region of `guide`, where light ratios are reconstructed: the slope of the ratio in
/// `ratios`, times the guide that it scales.
pub fn importance_of_ratios(ratios: &Frame, guide: &UpsampledGuide) -> Importance {
    let region = guide.region();
    let ratio = |x: u32, y: u32| sum(ratios.pixels()[y as usize * ratios.size().width as usize + x as usize]);
    let unshadowed = |x: u32, y: u32| {
        guide.row(y as usize).map_or(0.0, |row| sum(row[(x - region.x) as usize])) + 3.0 * EPSILON
    };
    let mut slopes = Blocks::new(region, ratio).squared_slopes();
    let guides = Blocks::new(region, unshadowed);
    for (slope, guide) in slopes.values.iter_mut().zip(&guides.values) {
        *slope *= guide * guide;
    }
    let errors = slopes.cells().into_iter().map(|error| error.powf(SHARE));
    Importance::new(region, errors.collect())
}

/// Red, green and blue together.
#[inline(always)]
fn sum([r, g, b, _]: [f32; 4]) -> f32 {
    r + g + b
}

/// Means of blocks of 2×2 pixels of a region.
struct Blocks {
    region: Region,
    size: [usize; 2],
    values: Vec<f32>,
}

impl Blocks {
    /// Means of the `value` of pixels (x, y) of the frame.
    fn new(region: Region, value: impl Fn(u32, u32) -> f32 + Sync) -> Self {
        let [width, height] = [region.size.width, region.size.height];
        let size = [width, height].map(|side| (side as usize).div_ceil(2));
        let mut values = vec![0.0; size[0] * size[1]];
        values.par_chunks_exact_mut(size[0]).enumerate().for_each(|(row, values)| {
            let rows = [0, 1].map(|i| region.y + (2 * row as u32 + i).min(height - 1));
            for (column, to) in values.iter_mut().enumerate() {
                let columns = [0, 1].map(|i| region.x + (2 * column as u32 + i).min(width - 1));
                let of_row = |y: u32| value(columns[0], y) + value(columns[1], y);
                *to = 0.25 * (of_row(rows[0]) + of_row(rows[1]));
            }
        });
        Self { region, size, values }
    }

    /// Squared slope of each block, by central differences.
    fn squared_slopes(&self) -> Self {
        let [columns, rows] = self.size;
        let mut values = vec![0.0; columns * rows];
        values.par_chunks_exact_mut(columns).enumerate().for_each(|(y, to)| {
            let row = |y: usize| &self.values[y * columns..][..columns];
            let (above, here, below) = (row(y.saturating_sub(1)), row(y), row((y + 1).min(rows - 1)));
            for x in 0..columns {
                let across = here[(x + 1).min(columns - 1)] - here[x.saturating_sub(1)];
                let down = below[x] - above[x];
                to[x] = across * across + down * down;
            }
        });
        Self { values, ..*self }
    }

    fn map(mut self, change: impl Fn(f32) -> f32) -> Self {
        self.values.iter_mut().for_each(|value| *value = change(*value));
        self
    }

    /// Means over the cells of an [`Importance`], each weighed with its neighbours (1 2 1 along both axes).
    fn cells(&self) -> Vec<f32> {
        let [columns, rows] = Importance::cells_of(self.region);
        let [width, height] = self.size;
        let mean = |at: usize| {
            let [x, y] = [at % columns, at / columns].map(|cell| 2 * cell);
            let value = |x: usize, y: usize| self.values[y.min(height - 1) * width + x.min(width - 1)];
            0.25 * (value(x, y) + value(x + 1, y) + value(x, y + 1) + value(x + 1, y + 1))
        };
        let means: Vec<f32> = (0..columns * rows).map(mean).collect();
        let near = |at: usize, count: usize| [at.saturating_sub(1), at, (at + 1).min(count - 1)];
        let blurred = |at: usize| {
            let (xs, ys) = (near(at % columns, columns), near(at / columns, rows));
            let weights = [0.25, 0.5, 0.25];
            let mut sum = 0.0;
            for (y, down) in ys.into_iter().zip(weights) {
                for (x, across) in xs.into_iter().zip(weights) {
                    sum += across * down * means[y * columns + x];
                }
            }
            sum
        };
        (0..columns * rows).map(blurred).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::guide::GuideGrid;
    use fovol_core::FrameSize;

    const SIZE: FrameSize = FrameSize { width: 64, height: 48 };

    /// Frame with an edge at column 32.
    fn edge() -> Frame {
        let mut frame = Frame::new(SIZE);
        for (i, pixel) in frame.pixels_mut().iter_mut().enumerate() {
            *pixel = if i % 64 < 32 { [0.2, 0.2, 0.2, 1.0] } else { [0.8, 0.8, 0.8, 1.0] };
        }
        frame
    }

    #[test]
    fn edges_are_important() {
        let region = Region { x: 4, y: 4, size: FrameSize { width: 57, height: 41 } };
        let found = importance_of_colours(&edge(), region);
        assert!(found.at(31, 20) > 3.0 && found.at(33, 40) > 3.0);
        assert_eq!([found.at(8, 20), found.at(60, 20)], [0.25; 2]);
    }

    #[test]
    fn slopes_of_the_ratio_count_where_the_guide_is_bright() {
        let grid = GuideGrid::new(1, 0, Region::whole(SIZE), SIZE);
        let guides: Vec<[f32; 4]> = (0..SIZE.pixels())
            .map(|i| if i / 64 < 24 { [0.0, 0.0, 0.0, 1.0] } else { [0.9, 0.9, 0.9, 1.0] })
            .collect();
        let found = importance_of_ratios(&edge(), &UpsampledGuide::new(grid, &guides, 1.0));
        assert!(found.at(31, 40) > 4.0 * found.at(31, 8) && found.at(31, 8) < 2.0);
        assert_eq!(found.at(8, 40), 0.25);
    }
}
