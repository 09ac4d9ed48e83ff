use super::pull_push::{Level, Pair, filled, halved};
use fovol_core::FrameSize;
use fovol_simd::{Simd, SimdOp};
use rayon::prelude::*;

/// Two scalar images, filled by pull-push. Values above 0 are known. An image without known values is 0 everywhere.
///
/// Only the known values and a filled image of half the resolution are stored. Values between are computed on
/// demand.
#[derive(Debug, Clone)]
pub struct FilledNumbers {
    size: FrameSize,
    known: [Vec<f32>; 2],
    /// Filled images at half the resolution.
    coarse: Level<Pair>,
}

impl FilledNumbers {
    /// Fills two images of a frame of `size`, given row by row. Values above 0 are known.
    ///
    /// # Panics
    /// When there is not one value for every pixel.
    pub fn new(size: FrameSize, known: [Vec<f32>; 2]) -> Self {
        assert!(known.iter().all(|numbers| numbers.len() == size.pixels()), "a number for every pixel");
        let [width, height] = [size.width, size.height].map(|side| side as usize);
        let coarse = filled(halved([width, height], [&known[0], &known[1]]));
        Self { size, known, coarse }
    }

    /// Size of the frame.
    pub fn size(&self) -> FrameSize {
        self.size
    }

    /// Both values of a pixel.
    ///
    /// # Panics
    /// Outside the frame.
    #[inline(always)]
    pub fn at(&self, [x, y]: [usize; 2]) -> [f32; 2] {
        let i = y * self.size.width as usize + x;
        let known = [self.known[0][i], self.known[1][i]];
        if known[0] > 0.0 && known[1] > 0.0 {
            return known;
        }
        let between = self.coarse.between([x, y]).numbers();
        [0, 1].map(|picture| if known[picture] > 0.0 { known[picture] } else { between[picture] })
    }

    /// Writes both values of all pixels of row `y` to `rows`. `line` is scratch memory.
    ///
    /// # Panics
    /// Outside the frame, and for rows of another width.
    #[inline(always)]
    pub fn row(&self, y: usize, rows: [&mut [f32]; 2], line: &mut Vec<f32>) {
        let width = self.size.width as usize;
        let half = self.coarse.width();
        // The border value is repeated at both ends.
        line.resize(half + 2, 0.0);
        for (picture, row) in rows.into_iter().enumerate() {
            let row = &mut row[..width];
            self.coarse.line(y, picture, &mut line[1..=half]);
            (line[0], line[half + 1]) = (line[1], line[half]);
            let known = &self.known[picture][y * width..][..width];
            let either = |known: f32, between: f32| if known > 0.0 { known } else { between };
            let (pairs, last) = row.as_chunks_mut::<2>();
            let (known, last_known) = known.as_chunks::<2>();
            let pixels = pairs.len();
            let (before, here, after) = (&line[..pixels], &line[1..=pixels], &line[2..pixels + 2]);
            for k in 0..pixels {
                let even = before[k] + 0.75 * (here[k] - before[k]);
                let odd = here[k] + 0.25 * (after[k] - here[k]);
                pairs[k] = [either(known[k][0], even), either(known[k][1], odd)];
            }
            if let ([last], [known]) = (last, last_known) {
                let (before, here) = (line[pixels], line[pixels + 1]);
                *last = either(*known, before + 0.75 * (here - before));
            }
        }
    }

    /// Both images, row by row.
    pub fn pictures(&self) -> [Vec<f32>; 2] {
        let width = self.size.width as usize;
        let mut pictures = [0, 1].map(|_| vec![0.0; self.size.pixels()]);
        let [first, second] = &mut pictures;
        let rows = first.par_chunks_mut(width).zip(second.par_chunks_mut(width)).enumerate();
        rows.for_each_init(Vec::new, |line, (y, (first, second))| {
            Simd::best().vectorised(Row { numbers: self, y, rows: [first, second], line });
        });
        pictures
    }
}

/// Operation that writes one row.
struct Row<'a> {
    numbers: &'a FilledNumbers,
    y: usize,
    rows: [&'a mut [f32]; 2],
    line: &'a mut Vec<f32>,
}

impl SimdOp for Row<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.numbers.row(self.y, self.rows, self.line);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fill::Fill;
    use fovol_core::{Frame, SparseFrame};
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(48))]
        #[test]
        fn numbers_are_filled_as_colours_are(w in 1u32..40, h in 1u32..30, few in 1u32..30, seed in 0u32..1000) {
            let size = FrameSize::new(w, h).unwrap();
            let mut frame = Frame::new(size);
            let random = |i: usize| (i as u32 ^ seed).wrapping_mul(2_654_435_761) >> 8;
            for (i, pixel) in frame.pixels_mut().iter_mut().enumerate() {
                if random(i).is_multiple_of(few) {
                    *pixel = [0.1 + (random(i + 7) % 100) as f32 / 50.0, 0.5, 0.25, 1.0];
                }
            }
            let known = |c: usize| frame.pixels().iter().map(|p| if p[3] > 0.5 { p[c] } else { 0.0 }).collect();
            let numbers = FilledNumbers::new(size, [known(0), known(1)]);
            let expected = Fill::PullPush.reconstruct(&SparseFrame::from(&frame));
            let pictures = numbers.pictures();
            for (i, pixel) in expected.pixels().iter().enumerate() {
                let alone = numbers.at([i % w as usize, i / w as usize]);
                for picture in 0..2 {
                    prop_assert!((pictures[picture][i] - pixel[picture]).abs() < 1e-5);
                    prop_assert!((alone[picture] - pixel[picture]).abs() < 1e-5);
                }
            }
        }
    }

    #[test]
    fn each_picture_has_its_own_known_numbers() {
        let size = FrameSize::new(23, 17).unwrap();
        let one: Vec<f32> = (0..size.pixels()).map(|i| if i % 11 == 0 { 0.7 } else { 0.0 }).collect();
        let numbers = FilledNumbers::new(size, [vec![0.0; size.pixels()], one]);
        let [nothing, constant] = numbers.pictures();
        assert!(nothing.iter().all(|number| *number == 0.0));
        assert!(constant.iter().all(|number| (number - 0.7).abs() < 1e-6));
    }
}
