//! From one level of the guide to the next finer one.

use super::grid::GuideGrid;
use super::{GuidePixel, possible};
use fovol_core::Pixel;
use rayon::prelude::*;

/// Weights of the four grid pixels around a place halfway between the middle two: Catmull and Rom's cubic.
const HALFWAY: [f32; 4] = [-1.0 / 16.0, 9.0 / 16.0, 9.0 / 16.0, -1.0 / 16.0];

/// Grid pixels that are added at the low and the high end of both axes, so that every pixel has its neighbours.
const BEFORE: usize = 2;
const AFTER: usize = 3;

/// A level of the guide, and the pixels that the next finer level has between its pixels.
pub struct Between {
    fine: GuideGrid,
    /// Columns and rows of the coarse level with those that are added.
    size: [usize; 2],
    /// Guide pixels of the coarse level, row by row. Beyond the region they are 0, or the nearest one at the edge of the
    /// frame.
    values: Vec<GuidePixel>,
    /// Places of the first fine pixel, in half distances between coarse pixels.
    offset: [usize; 2],
}

impl Between {
    /// Pixels of `fine` around those of `coarse`, which have the guide pixels `values`, row by row.
    pub fn new(coarse: &GuideGrid, fine: GuideGrid, values: &[GuidePixel]) -> Self {
        let [columns, rows] = coarse.size();
        let size = [columns, rows].map(|count| count + BEFORE + AFTER);
        let sources = [0, 1].map(|axis| sources(coarse, axis));
        let mut padded = vec![[0.0; 4]; size[0] * size[1]];
        for (to, from) in padded.chunks_exact_mut(size[0]).zip(&sources[1]) {
            let Some(from) = from else { continue };
            let from = &values[from * columns..][..columns];
            to[BEFORE..BEFORE + columns].copy_from_slice(from);
            let added = (0..BEFORE).chain(BEFORE + columns..size[0]);
            added.for_each(|at| to[at] = sources[0][at].map_or([0.0; 4], |source| from[source]));
        }
        let first = [coarse.first(), fine.first()];
        let offset = [0, 1].map(|axis| 2 * BEFORE - ((first[0][axis] - first[1][axis]) / fine.step) as usize);
        Self { fine, size, values: padded, offset }
    }

    fn row(&self, number: usize) -> &[GuidePixel] {
        &self.values[number * self.size[0]..][..self.size[0]]
    }

    /// Guide pixels of the fine level: those of the coarse one, and cubics between them.
    pub fn interpolated(&self) -> Vec<GuidePixel> {
        let [columns, rows] = self.fine.size();
        // Rows of the coarse level with the columns of the fine one.
        let mut wide = vec![[0.0; 4]; self.size[1] * columns];
        wide.par_chunks_exact_mut(columns).enumerate().for_each(|(y, to)| {
            let from = self.row(y);
            for (x, to) in to.iter_mut().enumerate() {
                let place = x + self.offset[0];
                let near = &from[place / 2 - 1..][..4];
                *to = match place % 2 {
                    0 => near[1],
                    _ => halfway([&near[0], &near[1], &near[2], &near[3]]),
                };
            }
        });
        let mut pixels = vec![[0.0; 4]; columns * rows];
        pixels.par_chunks_exact_mut(columns).enumerate().for_each(|(y, to)| {
            let place = y + self.offset[1];
            let row = |i: usize| &wide[(place / 2 - 1 + i) * columns..][..columns];
            if place.is_multiple_of(2) {
                return to.iter_mut().zip(row(1)).for_each(|(to, from)| *to = possible(*from));
            }
            let [a, b, c, d] = [0, 1, 2, 3].map(row);
            for x in 0..columns {
                to[x] = possible(halfway([&a[x], &b[x], &c[x], &d[x]]));
            }
        });
        pixels
    }

    /// Pixels of the fine level, with their indices there, whose coarse neighbours differ by `least` or more in a channel.
    /// If they are more than `most`, those whose neighbours differ most.
    pub fn contrasting(&self, least: f32, most: usize) -> (Vec<Pixel>, Vec<usize>) {
        let [columns, rows] = self.fine.size();
        let levels = Bytes::new(&self.values, self.size[0]);
        let mut contrasts = vec![0; columns * rows];
        contrasts.par_chunks_exact_mut(columns).enumerate().for_each_init(
            || [(); 2].map(|()| vec![0; self.size[0]]),
            |[straight, across], (y, to)| {
                let place = y + self.offset[1];
                levels.put_contrasts(place / 2, place.div_ceil(2), (straight, across));
                for (x, to) in to.iter_mut().enumerate() {
                    let place = x + self.offset[0];
                    *to = if place.is_multiple_of(2) { straight[place / 2] } else { across[place / 2] };
                }
            },
        );
        let Ok(limit) = u8::try_from(limit(&contrasts, (least * LEVELS) as u8, most)) else {
            return Default::default();
        };
        let (mut pixels, mut places) = (Vec::new(), Vec::new());
        for (y, row) in contrasts.chunks_exact(columns).enumerate() {
            for (i, part) in row.chunks(PART).enumerate() {
                // Most parts have nothing to choose, and are passed in one step.
                if part.iter().fold(0, |most, contrast| most.max(*contrast)) < limit {
                    continue;
                }
                for (x, contrast) in (i * PART..).zip(part) {
                    if *contrast >= limit {
                        pixels.push(self.fine.pixel(x, y));
                        places.push(y * columns + x);
                    }
                }
            }
        }
        (pixels, places)
    }
}

/// For each column or row of the padded level along `axis`, the one of `coarse` whose values it has; `None` for 0.
fn sources(coarse: &GuideGrid, axis: usize) -> Vec<Option<usize>> {
    let (region, frame) = (coarse.region, coarse.frame_size());
    let (begin, length, side) =
        [(region.x, region.size.width, frame.width), (region.y, region.size.height, frame.height)][axis];
    let last = coarse.size()[axis] - 1;
    let source = |at: usize| match at.checked_sub(BEFORE) {
        Some(inside) if inside <= last => Some(inside),
        Some(_) => (begin + length == side).then_some(last),
        None => (begin == 0).then_some(0),
    };
    (0..=last + BEFORE + AFTER).map(source).collect()
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

/// Contrast of 1 as a byte.
const LEVELS: f32 = 255.0;

/// `value`, 0…1, in steps of 1/[`LEVELS`]: added to 2²³ its integer is in the lowest bits, which is quicker than a conversion.
#[inline(always)]
fn byte(value: f32) -> u8 {
    (value.min(1.0) * LEVELS + 8_388_608.0).to_bits() as u8
}

/// Contrasts that are looked at together.
const PART: usize = 16;

/// Channels of guide pixels as bytes: differences of bytes are quicker to find.
struct Bytes {
    channels: Vec<Vec<u8>>,
    width: usize,
}

impl Bytes {
    fn new(values: &[GuidePixel], width: usize) -> Self {
        let channel = |c: usize| values.iter().map(|pixel| byte(pixel[c])).collect();
        Self { channels: (0..4).into_par_iter().map(channel).collect(), width }
    }

    /// Writes the greatest differences of a channel between the pixels of rows `above` and `below` of one column to the first
    /// slice, and those between a column and the next to the second.
    fn put_contrasts(&self, above: usize, below: usize, (straight, across): (&mut [u8], &mut [u8])) {
        straight.fill(0);
        across.fill(0);
        for channel in &self.channels {
            let row = |y: usize| &channel[y * self.width..][..self.width];
            let (above, below) = (row(above), row(below));
            for x in 0..self.width {
                straight[x] = straight[x].max(above[x].abs_diff(below[x]));
            }
            for x in 0..self.width - 1 {
                let low = above[x].min(below[x]).min(above[x + 1].min(below[x + 1]));
                let high = above[x].max(below[x]).max(above[x + 1].max(below[x + 1]));
                across[x] = across[x].max(high - low);
            }
        }
    }
}

/// Least contrast, at least `least` and at least 1, that no more than `most` of `contrasts` reach; 256 if there is none.
fn limit(contrasts: &[u8], least: u8, most: usize) -> u16 {
    let least = least.max(1);
    let mut counts = [0usize; 256];
    contrasts.iter().filter(|contrast| **contrast >= least).for_each(|at| counts[usize::from(*at)] += 1);
    let mut reached = 0;
    let mut limit = 256;
    for value in (least..=255).rev() {
        reached += counts[usize::from(value)];
        if reached > most {
            break;
        }
        limit = u16::from(value);
    }
    limit
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovol_core::{FrameSize, Region};
    use proptest::prelude::*;

    const FRAME: FrameSize = FrameSize { width: 60, height: 60 };

    /// Guide pixels of `grid`, where `value` gives that of a pixel.
    fn values(grid: &GuideGrid, value: impl Fn(Pixel) -> GuidePixel) -> Vec<GuidePixel> {
        grid.pixels().into_iter().map(value).collect()
    }

    proptest! {
        /// Catmull and Rom's cubic reproduces straight lines; the pixels of the coarse level stay.
        #[test]
        fn slopes_stay_slopes_away_from_the_border(
            (x, y) in (0u32..9, 0u32..9),
            (width, height) in (16u32..40, 16u32..40),
            index in 0u32..16,
        ) {
            let region = Region { x, y, size: FrameSize { width, height } };
            let slope = |pixel: Pixel| {
                let [x, y] = [pixel.x, pixel.y].map(f32::from);
                [0.005 * x, 0.004 * y, 0.002 * (x + y), 0.5 + 0.003 * (x + y)]
            };
            let coarsest = GuideGrid::coarsest(index, region, FRAME);
            for coarse in [coarsest, coarsest.finer().unwrap()] {
                let fine = coarse.finer().unwrap();
                let found = Between::new(&coarse, fine, &values(&coarse, slope)).interpolated();
                let border = 2 * coarse.step as usize;
                let is_inside = |pixel: Pixel| {
                    let [left, top] = [usize::from(pixel.x) - x as usize, usize::from(pixel.y) - y as usize];
                    left >= border && left + border < width as usize && top >= border && top + border < height as usize
                };
                let known = coarse.pixels();
                for (pixel, found) in fine.pixels().into_iter().zip(found) {
                    let expected = slope(pixel);
                    if is_inside(pixel) || known.contains(&pixel) {
                        prop_assert!((0..4).all(|c| (found[c] - expected[c]).abs() < 1e-5), "{found:?} {expected:?}");
                    }
                }
            }
        }

        /// Pixels are chosen whose nearest coarse neighbours differ, and no others.
        #[test]
        fn an_edge_is_found(column in 6u32..50, index in 0u32..16) {
            let coarse = GuideGrid::coarsest(index, Region::whole(FRAME), FRAME);
            let fine = coarse.finer().unwrap();
            let edge = |pixel: Pixel| [if u32::from(pixel.x) < column { 0.2 } else { 0.6 }; 4];
            let between = Between::new(&coarse, fine, &values(&coarse, edge));
            let (pixels, at) = between.contrasting(0.3, usize::MAX);
            let every = fine.pixels();
            prop_assert!(pixels.iter().eq(at.iter().map(|at| &every[*at])));
            let crosses = |pixel: &Pixel| {
                let before = u32::from(pixel.x) - 2;
                before < column && column <= before + 4 && before % 4 == coarse.first()[0] % 4
            };
            let expected: Vec<Pixel> = every.into_iter().filter(|pixel| pixel.x >= 2 && crosses(pixel)).collect();
            prop_assert_eq!(pixels, expected);
            prop_assert!(between.contrasting(0.5, usize::MAX).0.is_empty());
            prop_assert!(between.contrasting(0.3, 3).0.is_empty());
        }
    }

    #[test]
    fn the_edge_of_the_frame_repeats_and_nothing_lies_beyond_the_region() {
        let ones = |grid: &GuideGrid| values(grid, |_| [0.5, 0.5, 0.5, 1.0]);
        for index in 0..16 {
            let coarse = GuideGrid::coarsest(index, Region::whole(FRAME), FRAME);
            let between = Between::new(&coarse, coarse.finer().unwrap(), &ones(&coarse));
            assert!(between.interpolated().iter().all(|p| (p[3] - 1.0).abs() < 1e-6));
            assert!(between.contrasting(0.1, usize::MAX).0.is_empty());
        }
        let region = Region { x: 4, y: 2, size: FrameSize { width: 16, height: 16 } };
        let coarse = GuideGrid::coarsest(0, region, FRAME);
        let between = Between::new(&coarse, coarse.finer().unwrap(), &ones(&coarse));
        assert!(between.interpolated()[0][3] < 0.7);
        assert_eq!(between.contrasting(0.1, usize::MAX).0[0], Pixel { x: 5, y: 3 });
    }

    proptest! {
        #[test]
        fn the_strongest_contrasts_come_first(
            contrasts in proptest::collection::vec(0u8.., 0..40),
            least in 0u8..20,
            most in 0usize..40,
        ) {
            let reach = |limit: u16| contrasts.iter().filter(|contrast| u16::from(**contrast) >= limit).count();
            let limit = limit(&contrasts, least, most);
            prop_assert!(reach(limit) <= most && limit >= u16::from(least.max(1)));
            prop_assert!(limit == u16::from(least.max(1)) || reach(limit - 1) > most);
        }
    }
}
