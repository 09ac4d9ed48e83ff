use crate::{Frame, FrameSize, Pixel, Region, SampleList};
use std::ops::Range;

/// Sampled pixels of a frame with their colours and depths, in raster order.
#[derive(Debug, Clone, PartialEq)]
pub struct SparseFrame {
    list: SampleList,
    /// Index of the first sample of each row, and the number of samples as the last entry.
    row_starts: Vec<u32>,
    colours: Vec<[f32; 3]>,
    depths: Vec<f32>,
}

impl SparseFrame {
    /// Sparse frame of the pixels of `list`, with a colour and a depth for each.
    ///
    /// Colours are display values over the background. A depth is a distance from the eye in world units; it is infinite
    /// where the ray met nothing. Pixels that are not in raster order are sorted. A pixel that is listed twice keeps its
    /// last entry.
    ///
    /// # Panics
    /// If the numbers of pixels, colours and depths differ.
    pub fn new(list: SampleList, colours: Vec<[f32; 3]>, depths: Vec<f32>) -> Self {
        let counts = [colours.len(), depths.len()];
        assert!(
            counts.iter().all(|count| *count == list.len()),
            "a colour and a depth for every listed pixel"
        );
        let Some(order) = list.raster_order() else { return Self::in_order(list, colours, depths) };
        let sorted = SampleList::new(list.size(), order.iter().map(|at| list.pixels()[*at]).collect());
        let colours = order.iter().map(|at| colours[*at]).collect();
        Self::in_order(sorted, colours, order.iter().map(|at| depths[*at]).collect())
    }

    /// Sparse frame of a `list` in raster order.
    fn in_order(list: SampleList, colours: Vec<[f32; 3]>, depths: Vec<f32>) -> Self {
        let mut row_starts = vec![0; list.size().height as usize + 1];
        for pixel in list.pixels() {
            row_starts[usize::from(pixel.y) + 1] += 1;
        }
        let mut sum = 0;
        for start in &mut row_starts {
            sum += *start;
            *start = sum;
        }
        Self { list, row_starts, colours, depths }
    }

    /// Width and height of the frame.
    pub fn size(&self) -> FrameSize {
        self.list.size()
    }

    /// Sampled pixels in raster order.
    pub fn pixels(&self) -> &[Pixel] {
        self.list.pixels()
    }

    /// Colours of the samples: display values over the background.
    pub fn colours(&self) -> &[[f32; 3]] {
        &self.colours
    }

    /// Depths of the samples: distances from the eye in world units; infinite where the ray met nothing, or where the
    /// depth is unknown.
    pub fn depths(&self) -> &[f32] {
        &self.depths
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// Whether there are no samples.
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// Indices of the samples of row `y`.
    ///
    /// # Panics
    /// If the row lies outside the frame.
    #[inline]
    pub fn row(&self, y: usize) -> Range<usize> {
        self.row_starts[y] as usize..self.row_starts[y + 1] as usize
    }

    /// Indices of the samples of row `y` in the columns `columns`.
    ///
    /// # Panics
    /// If the row lies outside the frame.
    #[inline]
    pub fn row_part(&self, y: usize, columns: Range<usize>) -> Range<usize> {
        let row = self.row(y);
        let pixels = &self.pixels()[row.clone()];
        let before = |end: usize| row.start + pixels.partition_point(|pixel| usize::from(pixel.x) < end);
        before(columns.start)..before(columns.end)
    }

    /// Copy of the samples in `region`, with positions relative to its top left pixel.
    #[must_use]
    pub fn within(&self, region: Region) -> Self {
        let columns = region.x as usize..(region.x + region.size.width) as usize;
        let rows = region.y as usize..(region.y + region.size.height) as usize;
        let parts: Vec<Range<usize>> = rows.map(|y| self.row_part(y, columns.clone())).collect();
        let of = || parts.iter().cloned().flatten();
        let moved = |pixel: Pixel| Pixel { x: pixel.x - region.x as u16, y: pixel.y - region.y as u16 };
        let list = SampleList::new(region.size, of().map(|at| moved(self.pixels()[at])).collect());
        let colours = of().map(|at| self.colours[at]).collect();
        Self::in_order(list, colours, of().map(|at| self.depths[at]).collect())
    }

    /// Picture of the samples: alpha 1 at samples, transparent black elsewhere.
    pub fn to_frame(&self) -> Frame {
        let mut frame = Frame::new(self.size());
        let width = self.size().width;
        let pixels = frame.pixels_mut();
        for (pixel, [r, g, b]) in self.pixels().iter().zip(&self.colours) {
            pixels[pixel.index(width)] = [*r, *g, *b, 1.0];
        }
        frame
    }
}

/// Samples of a picture: its pixels with alpha above ½. Their depths are unknown.
impl From<&Frame> for SparseFrame {
    fn from(frame: &Frame) -> Self {
        let size = frame.size();
        let rows = frame.pixels().chunks_exact(size.width as usize).enumerate();
        let sampled = rows.flat_map(|(y, row)| {
            let pixels = row.iter().enumerate().filter(|(_, [.., alpha])| *alpha > 0.5);
            pixels.map(move |(x, [r, g, b, _])| (Pixel { x: x as u16, y: y as u16 }, [*r, *g, *b]))
        });
        let (pixels, colours): (Vec<_>, Vec<_>) = sampled.unzip();
        let depths = vec![f32::INFINITY; pixels.len()];
        Self::in_order(SampleList::new(size, pixels), colours, depths)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn samples_are_opaque_and_other_pixels_clear() {
        let list = SampleList::new(
            FrameSize { width: 3, height: 2 },
            vec![Pixel { x: 2, y: 1 }, Pixel { x: 0, y: 0 }],
        );
        let sparse =
            SparseFrame::new(list, vec![[0.5, 0.25, 0.125], [1.0, 0.0, 0.0]], vec![1.0, f32::INFINITY]);
        let frame = sparse.to_frame();
        assert_eq!(frame.pixel(2, 1), [0.5, 0.25, 0.125, 1.0]);
        assert_eq!(frame.pixel(0, 0), [1.0, 0.0, 0.0, 1.0]);
        assert_eq!(frame.pixel(1, 1), [0.0; 4]);
        assert_eq!(sparse.depths(), [f32::INFINITY, 1.0]);
    }

    proptest! {
        #[test]
        fn samples_are_sorted_and_the_last_of_equal_pixels_is_kept(
            (w, h) in (1u32..20, 1u32..20),
            drawn in prop::collection::vec((any::<u16>(), any::<u16>(), 0.0f32..1.0), 0..80),
            (x, y) in (any::<u32>(), any::<u32>()),
        ) {
            let size = FrameSize::new(w, h).unwrap();
            let pixel = |x: u16, y: u16| Pixel { x: x % w as u16, y: y % h as u16 };
            let list = SampleList::new(size, drawn.iter().map(|(x, y, _)| pixel(*x, *y)).collect());
            let values = drawn.iter().map(|(.., value)| *value);
            let mut expected = Frame::new(size);
            for (pixel, value) in list.pixels().iter().zip(values.clone()) {
                expected.pixels_mut()[pixel.index(w)] = [value, 0.5, 0.25, 1.0];
            }
            let colours = values.clone().map(|value| [value, 0.5, 0.25]).collect();
            let sparse = SparseFrame::new(list, colours, values.collect());
            prop_assert_eq!(&sparse.to_frame(), &expected);
            prop_assert!(sparse.pixels().is_sorted_by_key(|pixel| (pixel.y, pixel.x)));
            prop_assert!(sparse.colours().iter().zip(sparse.depths()).all(|(colour, depth)| colour[0] == *depth));
            let of_picture = SparseFrame::from(&expected);
            prop_assert_eq!((of_picture.pixels(), of_picture.colours()), (sparse.pixels(), sparse.colours()));
            let (x, y) = (x % w, y % h);
            let region = Region { x, y, size: FrameSize { width: w - x, height: (h - y).div_ceil(2) } };
            prop_assert_eq!(sparse.within(region).to_frame(), region.of(&expected));
        }
    }
}
