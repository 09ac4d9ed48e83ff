use super::{GuideGrid, GuidePixel};
use fovol_core::{Frame, FrameSize, Pixel, Region};
use rayon::prelude::*;

/// Guide of every pixel of a region.
///
/// Between the pixels of the grid it is interpolated with Catmull and Rom's cubic. Beyond the region nothing is visible,
/// so the guide is 0 there; at the edge of the frame the nearest value is repeated.
#[derive(Debug, Clone, PartialEq)]
pub struct UpsampledGuide {
    region: Region,
    /// How many times as bright as the guide a pixel can be: the light ratio is scaled to 0…1 by it.
    headroom: f32,
    pixels: Vec<GuidePixel>,
}

/// Weights of the four grid pixels around a place halfway between the middle two.
const HALFWAY: [f32; 4] = [-1.0 / 16.0, 9.0 / 16.0, 9.0 / 16.0, -1.0 / 16.0];

impl UpsampledGuide {
    /// Interpolates the guide pixels `marched` of `grid`, row by row. Colours are at most `headroom` times as bright.
    ///
    /// # Panics
    /// If their number is not that of the grid.
    pub fn new(grid: GuideGrid, marched: &[GuidePixel], headroom: f32) -> Self {
        let [columns, rows] = grid.size();
        assert_eq!(marched.len(), columns * rows, "a guide pixel for every pixel of the grid");
        let region = grid.region;
        if grid.step == 1 {
            return Self { region, headroom, pixels: marched.to_vec() };
        }
        let width = region.size.width as usize;
        // Rows of the grid at the full width, then the rows between them.
        let mut wide = vec![[0.0; 4]; rows * width];
        let across = Along::new(&grid, 0);
        wide.par_chunks_exact_mut(width)
            .zip(marched.par_chunks_exact(columns.max(1)))
            .for_each_init(Vec::new, |padded, (to, from)| across.put_row(from, padded, to));
        let mut pixels = vec![[0.0; 4]; region.pixels()];
        let (down, nothing) = (Along::new(&grid, 1), vec![[0.0; 4]; width]);
        pixels.par_chunks_exact_mut(width).enumerate().for_each(|(y, to)| {
            let row = |number: usize| match down.grid_pixel(number) {
                Some(row) => &wide[row * width..][..width],
                None => &nothing[..],
            };
            down.put_between(y, row, to);
        });
        Self { region, headroom, pixels }
    }

    /// How many times as bright as the guide a pixel can be.
    pub fn headroom(&self) -> f32 {
        self.headroom
    }

    /// Region that it covers.
    pub fn region(&self) -> Region {
        self.region
    }

    /// Guide pixels of row `y` of the frame; `None` outside the region.
    pub fn row(&self, y: usize) -> Option<&[GuidePixel]> {
        let row = y.checked_sub(self.region.y as usize)?;
        self.pixels.chunks_exact(self.region.size.width as usize).nth(row)
    }

    /// Picture of `size`: red, green and blue are U, alpha is O.
    pub fn to_frame(&self, size: FrameSize) -> Frame {
        let mut frame = Frame::new(size);
        self.region.put_part(&self.pixels, frame.pixels_mut(), size.width);
        frame
    }

    /// Guide of a whole `frame`: red, green and blue are U, alpha is O. Values are clamped to those that are possible;
    /// numbers that are not finite count as 0.
    pub fn of_frame(frame: &Frame) -> Self {
        let known = |value: f32| if value.is_finite() { value } else { 0.0 };
        let pixels = frame.pixels().iter().map(|pixel| possible(pixel.map(known))).collect();
        Self { region: Region::whole(frame.size()), headroom: 1.0, pixels }
    }

    /// Guide of `pixel` of the frame; `None` outside the region.
    pub fn at(&self, pixel: Pixel) -> Option<GuidePixel> {
        self.index(pixel).map(|at| self.pixels[at])
    }

    /// Index of `pixel` of the frame in the guide.
    fn index(&self, pixel: Pixel) -> Option<usize> {
        let [x, y] = self.region.inside(pixel.x.into(), pixel.y.into())?;
        Some(y as usize * self.region.size.width as usize + x as usize)
    }

    /// Replaces the guide of `pixel` of the frame by its exact value. Nothing happens outside the region.
    pub fn put(&mut self, pixel: Pixel, guide: GuidePixel) {
        if let Some(at) = self.index(pixel) {
            self.pixels[at] = guide;
        }
    }
}

/// Clamps overshoots of the cubic: opacity lies in 0…1, and no channel above opacity.
#[inline(always)]
fn possible([r, g, b, opacity]: GuidePixel) -> GuidePixel {
    let opacity = opacity.clamp(0.0, 1.0);
    [r.clamp(0.0, opacity), g.clamp(0.0, opacity), b.clamp(0.0, opacity), opacity]
}

/// Interpolation along one axis, from every second pixel to every pixel of the region.
struct Along {
    /// Pixels of the region before the first one of the grid: 0 or 1.
    before: usize,
    /// Number of grid pixels.
    count: usize,
    /// Whether the region ends at the frame's low and high edge.
    is_edge: [bool; 2],
}

impl Along {
    fn new(grid: &GuideGrid, axis: usize) -> Self {
        let region = [
            (grid.region.x, grid.region.size.width, grid.frame_size().width),
            (grid.region.y, grid.region.size.height, grid.frame_size().height),
        ];
        let (first, length, frame) = region[axis];
        Self {
            before: (grid.first()[axis] - first) as usize,
            count: grid.size()[axis],
            is_edge: [first == 0, first + length == frame],
        }
    }

    /// Place of pixel `at` of the region in half grid distances, where grid pixel `number` has the place 2·`number` + 4.
    fn place(&self, at: usize) -> usize {
        at + 4 - self.before
    }

    /// Grid pixel with the place 2·`number`, also beyond both ends of the grid; `None` where the guide is 0.
    fn grid_pixel(&self, number: usize) -> Option<usize> {
        let [repeats_first, repeats_last] = self.is_edge;
        let last = self.count.checked_sub(1)?;
        match number.checked_sub(2) {
            Some(inside) if inside <= last => Some(inside),
            Some(_) => repeats_last.then_some(last),
            None => repeats_first.then_some(0),
        }
    }

    /// Writes all pixels of a row of the region to `to`, from the grid pixels `from`. `padded` is scratch memory.
    fn put_row(&self, from: &[GuidePixel], padded: &mut Vec<GuidePixel>, to: &mut [GuidePixel]) {
        let pixel = |number| self.grid_pixel(number).map_or([0.0; 4], |at| from[at]);
        padded.clear();
        padded.extend([pixel(0), pixel(1)]);
        padded.extend_from_slice(from);
        padded.extend((self.count + 2..self.count + 5).map(pixel));
        for (x, to) in to.iter_mut().enumerate() {
            let place = self.place(x);
            let near = &padded[place / 2 - 1..][..4];
            *to = if place.is_multiple_of(2) {
                near[1]
            } else {
                halfway([&near[0], &near[1], &near[2], &near[3]])
            };
        }
    }

    /// Writes the pixels of row `y` of the region to `to`, where `row` gives the rows of the grid by their numbers.
    fn put_between<'a>(&self, y: usize, row: impl Fn(usize) -> &'a [GuidePixel], to: &mut [GuidePixel]) {
        let place = self.place(y);
        let middle = place / 2;
        if place.is_multiple_of(2) {
            to.iter_mut().zip(row(middle)).for_each(|(to, from)| *to = possible(*from));
            return;
        }
        let width = to.len();
        let [a, b, c, d] = [0, 1, 2, 3].map(|i| &row(middle - 1 + i)[..width]);
        for x in 0..width {
            to[x] = possible(halfway([&a[x], &b[x], &c[x], &d[x]]));
        }
    }
}

/// Cubic halfway between the middle two of four neighbours.
#[inline(always)]
fn halfway(near: [&GuidePixel; 4]) -> GuidePixel {
    let mut sum = [0.0; 4];
    for (weight, pixel) in HALFWAY.into_iter().zip(near) {
        for c in 0..4 {
            sum[c] += weight * pixel[c];
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Catmull and Rom's cubic reproduces straight lines; the pixels of the grid stay.
        #[test]
        fn slopes_stay_slopes_away_from_the_border(
            (x, y) in (0u32..9, 0u32..9),
            (width, height) in (8u32..30, 8u32..30),
            index in 0u32..4,
        ) {
            let frame = FrameSize { width: 60, height: 60 };
            let region = Region { x, y, size: FrameSize { width, height } };
            let grid = GuideGrid::new(2, index, region, frame);
            let slope = |pixel: Pixel| {
                let [x, y] = [pixel.x, pixel.y].map(f32::from);
                [0.005 * x, 0.004 * y, 0.002 * (x + y), 0.5 + 0.003 * (x + y)]
            };
            let marched: Vec<GuidePixel> = grid.list().pixels().iter().map(|pixel| slope(*pixel)).collect();
            let guide = UpsampledGuide::new(grid, &marched, 1.0);
            for row in 4..height - 4 {
                let found = guide.row((y + row) as usize).unwrap();
                for column in 4..width - 4 {
                    let expected = slope(Pixel { x: (x + column) as u16, y: (y + row) as u16 });
                    let found = found[column as usize];
                    prop_assert!((0..4).all(|c| (found[c] - expected[c]).abs() < 1e-5), "{found:?} {expected:?}");
                }
            }
            for (pixel, exact) in grid.list().pixels().iter().zip(&marched) {
                let found = guide.row(usize::from(pixel.y)).unwrap()[usize::from(pixel.x) - x as usize];
                prop_assert!((0..4).all(|c| (found[c] - exact[c]).abs() < 1e-6));
            }
            prop_assert!(guide.row((y + height) as usize).is_none());
        }
    }

    #[test]
    fn the_edge_of_the_frame_repeats_and_nothing_lies_beyond_the_region() {
        let frame = FrameSize { width: 12, height: 9 };
        let ones = |grid: &GuideGrid| vec![[0.5, 0.5, 0.5, 1.0]; grid.size()[0] * grid.size()[1]];
        for index in 0..4 {
            let grid = GuideGrid::new(2, index, Region::whole(frame), frame);
            let guide = UpsampledGuide::new(grid, &ones(&grid), 1.0);
            assert!((0..9).all(|y| guide.row(y).unwrap().iter().all(|p| (p[3] - 1.0).abs() < 1e-6)));
        }
        let region = Region { x: 4, y: 2, size: FrameSize { width: 4, height: 4 } };
        let grid = GuideGrid::new(2, 0, region, frame);
        let mut guide = UpsampledGuide::new(grid, &ones(&grid), 1.0);
        assert!(guide.row(2).unwrap()[0][3] < 0.7);
        guide.put(Pixel { x: 4, y: 2 }, [0.25; 4]);
        guide.put(Pixel { x: 0, y: 0 }, [0.75; 4]);
        assert_eq!(guide.row(2).unwrap()[0], [0.25; 4]);
    }
}
