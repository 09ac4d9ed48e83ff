use super::UpsampledGuide;
use fovol_core::{Frame, Pixel, SparseFrame};
use fovol_net::Fill;
use rayon::prelude::*;

/// Edge of the squares in which samples are looked for, in pixels. A pixel takes those of its square and of the eight
/// around it.
const SQUARE: usize = 12;

/// Standard deviation of the distance on the screen, in distances of neighbouring samples.
const NEAR: f32 = 0.45;

/// Standard deviation of the difference of guide pixels.
const ALIKE: f32 = 0.12;

/// Samples of a square from which on it is dense by itself.
const ENOUGH: usize = 8;

/// Weight of pull-push: it decides where no sample is near and alike.
const FALLBACK: f32 = 1e-3;

/// Fills the light ratios `ratios` without a network: means of the samples that are near and whose `guide` is alike
/// (joint bilateral upsampling; Kopf, Cohen, Lischinski, Uyttendaele 2007). Pixels outside the guide are white.
///
/// It is what the network of the light ratio is compared with.
pub fn joint_bilateral(ratios: &SparseFrame, guide: &UpsampledGuide) -> Frame {
    let mut frame = Fill::PullPush.reconstruct(ratios);
    let squares = Squares::new(ratios, guide);
    let width = frame.size().width as usize;
    frame.pixels_mut().par_chunks_exact_mut(width).enumerate().for_each(|(y, row)| {
        let Some(guides) = guide.row(y) else { return row.fill([1.0; 4]) };
        let first = guide.region().x as usize;
        row[..first].fill([1.0; 4]);
        row[first + guides.len()..].fill([1.0; 4]);
        let mut last = (usize::MAX, 1.0);
        for (x, guide) in (first..).zip(guides) {
            let column = x / SQUARE;
            if last.0 != column {
                last = (column, squares.nearness(column, y / SQUARE));
            }
            row[x] = squares.mean([x, y], guide, last.1, row[x]);
        }
    });
    frame
}

/// Sample of the light ratio and its guide pixel.
struct Sample {
    pixel: Pixel,
    guide: [f32; 4],
    ratio: [f32; 3],
}

/// Samples by the square that they lie in.
struct Squares {
    columns: usize,
    squares: Vec<Vec<Sample>>,
}

impl Squares {
    fn new(ratios: &SparseFrame, guide: &UpsampledGuide) -> Self {
        let size = ratios.size();
        let [columns, rows] = [size.width, size.height].map(|side| (side as usize).div_ceil(SQUARE));
        let mut squares: Vec<Vec<Sample>> = (0..columns * rows).map(|_| Vec::new()).collect();
        for (pixel, ratio) in ratios.pixels().iter().zip(ratios.colours()) {
            let Some(guide) = guide.at(*pixel) else { continue };
            let at = usize::from(pixel.y) / SQUARE * columns + usize::from(pixel.x) / SQUARE;
            squares[at].push(Sample { pixel: *pixel, guide, ratio: *ratio });
        }
        Self { columns, squares }
    }

    /// 1/σ² of the distance on the screen in the square in `column` and `row`. Where it holds few samples, those around
    /// it count, too.
    fn nearness(&self, column: usize, row: usize) -> f32 {
        let own = self.squares[row * self.columns + column].len();
        let (count, area) = match own {
            ENOUGH.. => (own, SQUARE * SQUARE),
            _ => (self.around(column, row).map(<[Sample]>::len).sum(), 9 * SQUARE * SQUARE),
        };
        count as f32 / (area as f32 * NEAR * NEAR)
    }

    /// Weighed mean at pixel (`x`, `y`) with the guide pixel `guide` and the [`Self::nearness`] of its square; `fallback`
    /// is added with a small weight.
    fn mean(&self, [x, y]: [usize; 2], guide: &[f32; 4], near: f32, fallback: [f32; 4]) -> [f32; 4] {
        let mut sum = fallback.map(|value| FALLBACK * value);
        for sample in self.around(x / SQUARE, y / SQUARE).flatten() {
            let [dx, dy] = [f32::from(sample.pixel.x) - x as f32, f32::from(sample.pixel.y) - y as f32];
            let apart: f32 = guide.iter().zip(&sample.guide).map(|(a, b)| (a - b) * (a - b)).sum();
            let distance = near * (dx * dx + dy * dy) + apart / (ALIKE * ALIKE);
            let weight = (-0.5 * distance).exp();
            (0..3).for_each(|c| sum[c] += weight * sample.ratio[c]);
            sum[3] += weight;
        }
        let [r, g, b, weight] = sum;
        [r / weight, g / weight, b / weight, 1.0]
    }

    /// Samples of the square in `column` and `row`, and of those around it.
    fn around(&self, column: usize, row: usize) -> impl Iterator<Item = &[Sample]> {
        let rows = self.squares.len() / self.columns;
        let columns = column.saturating_sub(1)..(column + 2).min(self.columns);
        (row.saturating_sub(1)..(row + 2).min(rows)).flat_map(move |row| {
            columns.clone().map(move |column| &self.squares[row * self.columns + column][..])
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovol_core::{FrameSize, Region, SampleList};

    #[test]
    fn edges_of_the_guide_stay_and_all_samples_count() {
        let size = FrameSize { width: 40, height: 30 };
        let region = Region { x: 2, y: 3, size: FrameSize { width: 36, height: 25 } };
        let is_left = |x: u32| x < 21;
        let guides = (0..region.pixels() as u32).map(|i| {
            let value = if is_left(i % region.size.width + region.x) { 0.2 } else { 0.9 };
            [value, value, value, 1.0]
        });
        let guide = UpsampledGuide::new(region, guides.collect(), 1.0);
        let pixels: Vec<Pixel> =
            [(5, 5), (15, 20), (19, 10), (24, 10), (34, 24)].map(|(x, y)| Pixel { x, y }).to_vec();
        let lit = |x: u32| if is_left(x) { 0.4 } else { 0.8 };
        let colours = pixels.iter().map(|pixel| [lit(pixel.x.into()); 3]).collect();
        let ratios = SparseFrame::new(SampleList::new(size, pixels), colours, vec![1.0; 5]);
        let frame = joint_bilateral(&ratios, &guide);
        for (x, y) in (2..38).flat_map(|x| (3..28).map(move |y| (x, y))) {
            let is_near = ratios.pixels().iter().any(|pixel| {
                let [dx, dy] = [f32::from(pixel.x) - x as f32, f32::from(pixel.y) - y as f32];
                is_left(pixel.x.into()) == is_left(x) && dx.hypot(dy) < 10.0
            });
            let error = (frame.pixel(x, y)[0] - lit(x)).abs();
            assert!(if is_near { error < 0.01 } else { error < 0.41 }, "({x}, {y}): {error}");
        }
        assert_eq!([frame.pixel(0, 0), frame.pixel(39, 10)], [[1.0; 4]; 2]);
    }
}
