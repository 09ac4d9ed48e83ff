use super::{EPSILON, UpsampledGuide};
use fovol_core::{Frame, Region};
use fovol_render::Importance;
use rayon::prelude::*;

/// Density that makes the sum of squared errors least, from the error at even density: error^(9/16). With errors that
/// fall as density^−γ the exponent is 1/(1 + γ); measured, γ is 0.75 to 0.9. Roots are faster than powers.
fn best_density(error: f32) -> f32 {
    let half = error.sqrt();
    half * half.sqrt().sqrt().sqrt()
}

/// Importance of samples in `region` for the next frame, where colours are reconstructed: the slope of `frame`.
pub fn importance_of_colours(frame: &Frame, region: Region) -> Importance {
    let mut slopes = Blocks::new(region, |y| part(frame, region, y)).squared_slopes();
    slopes.values.iter_mut().for_each(|slope| *slope = slope.sqrt());
    Importance::new(region, slopes.cells())
}

/// Importance of samples in the region of `guide`, where light ratios are reconstructed: the slope of the ratio in
/// `ratios`, times the guide that it scales.
pub fn importance_of_ratios(ratios: &Frame, guide: &UpsampledGuide) -> Importance {
    let region = guide.region();
    let mut slopes = Blocks::new(region, |y| part(ratios, region, y)).squared_slopes();
    let guides = Blocks::new(region, |y| guide.row(y).unwrap_or_default());
    for (slope, guide) in slopes.values.iter_mut().zip(&guides.values) {
        *slope *= (guide + 3.0 * EPSILON).powi(2);
    }
    let mut errors = slopes.cells();
    errors.iter_mut().for_each(|error| *error = best_density(*error));
    Importance::new(region, errors)
}

/// Pixels of row `y` of `frame` that lie in `region`.
fn part(frame: &Frame, region: Region, y: usize) -> &[[f32; 4]] {
    &frame.pixels()[y * frame.size().width as usize + region.x as usize..][..region.size.width as usize]
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
    /// Means of the sums of red, green and blue, where `row` gives the pixels of a row of the frame within the region.
    fn new<'a>(region: Region, row: impl Fn(usize) -> &'a [[f32; 4]] + Sync) -> Self {
        let [width, height] = [region.size.width, region.size.height].map(|side| side as usize);
        let size = [width, height].map(|side| side.div_ceil(2));
        let mut values = vec![0.0; size[0] * size[1]];
        values.par_chunks_exact_mut(size[0]).enumerate().for_each(|(y, values)| {
            let [above, below] =
                [0, 1].map(|i| &row(region.y as usize + (2 * y + i).min(height - 1))[..width]);
            for (x, to) in values.iter_mut().enumerate() {
                let (left, right) = (2 * x, (2 * x + 1).min(width - 1));
                let upper = sum(above[left]) + sum(above[right]);
                *to = 0.25 * (upper + sum(below[left]) + sum(below[right]));
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

    /// Means over the cells of an [`Importance`], each weighed with its neighbours (1 2 1 along both axes).
    fn cells(&self) -> Vec<f32> {
        let [columns, rows] = Importance::cells_of(self.region);
        let [width, height] = self.size;
        let mean = |at: usize| {
            let [x, y] = [at % columns, at / columns].map(|cell| 2 * cell);
            let value = |x: usize, y: usize| self.values[y.min(height - 1) * width + x.min(width - 1)];
            0.25 * (value(x, y) + value(x + 1, y) + value(x, y + 1) + value(x + 1, y + 1))
        };
        let means: Vec<f32> = (0..columns * rows).into_par_iter().map(mean).collect();
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
        (0..columns * rows).into_par_iter().map(blurred).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
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
    fn densities_rise_slower_than_errors() {
        assert_eq!(best_density(0.0), 0.0);
        assert!((best_density(3.0) - 3f32.powf(9.0 / 16.0)).abs() < 1e-5);
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
        let guides: Vec<[f32; 4]> = (0..SIZE.pixels())
            .map(|i| if i / 64 < 24 { [0.0, 0.0, 0.0, 1.0] } else { [0.9, 0.9, 0.9, 1.0] })
            .collect();
        let found = importance_of_ratios(&edge(), &UpsampledGuide::new(Region::whole(SIZE), guides, 1.0));
        assert!(found.at(31, 40) > 4.0 * found.at(31, 8) && found.at(31, 8) < 2.0);
        assert_eq!(found.at(8, 40), 0.25);
    }
}
