//! Samples of a frame as lists, without the pixels between them.

use crate::cpu::tensor::Tensor;
use fovol_core::{Frame, FrameSize};
use glam::Vec4;
use rayon::prelude::*;

/// A weighted pixel: three values times the weight, and the weight, 0…1.
pub type PremulRgba = [f32; 4];

/// A sampled pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Column.
    pub x: u32,
    /// Colour, 0…1.
    pub colour: [f32; 3],
}

impl Sample {
    /// Returns the sample as a premultiplied pixel of weight 1.
    #[inline(always)]
    pub fn known(&self) -> Vec4 {
        let [r, g, b] = self.colour;
        Vec4::new(r, g, b, 1.0)
    }
}

/// Samples of a frame, row by row, from left to right.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Samples {
    rows: Vec<Vec<Sample>>,
    width: usize,
}

impl Samples {
    /// Collects the samples of `sparse`. Frames smaller than `height` × `width` are replicated at the right and
    /// bottom.
    pub fn gather(&mut self, sparse: &Frame, [height, width]: [usize; 2]) {
        self.width = width;
        self.rows.resize_with(height, Vec::new);
        let FrameSize { width: columns, height: lines } = sparse.size();
        let (columns, lines) = (columns as usize, lines as usize);
        self.rows.par_iter_mut().enumerate().for_each(|(y, samples)| {
            let from = y.min(lines - 1) * columns;
            let row = &sparse.pixels()[from..from + columns];
            let found = row.iter().enumerate().filter(|(_, pixel)| is_sampled(pixel));
            let sample = |(x, pixel): (usize, &[f32; 4])| Sample { x: x as u32, colour: colour(pixel) };
            samples.clear();
            // Counted first, because growing vectors would take up to twice the memory.
            samples.reserve_exact(row.iter().filter(|pixel| pixel[3] > 0.5).count());
            samples.extend(found.map(sample));
            if let Some(&last) = samples.last().filter(|last| last.x as usize == columns - 1) {
                samples.extend((columns..width).map(|x| Sample { x: x as u32, ..last }));
            }
        });
    }

    /// Rows and columns.
    pub fn size(&self) -> [usize; 2] {
        [self.rows.len(), self.width]
    }

    /// Samples of row `y`.
    pub fn row(&self, y: usize) -> &[Sample] {
        &self.rows[y]
    }
}

/// Whether `pixel` of a sparse frame was sampled: its alpha is above ½, and all values are finite.
#[inline]
pub fn is_sampled(pixel: &[f32; 4]) -> bool {
    pixel[3] > 0.5 && pixel.iter().all(|v| v.is_finite())
}

/// Colour of a sampled `pixel`, clamped to 0…1.
#[inline]
pub fn colour([r, g, b, _]: &[f32; 4]) -> [f32; 3] {
    [r.clamp(0.0, 1.0), g.clamp(0.0, 1.0), b.clamp(0.0, 1.0)]
}

/// Weighted pixels of a frame.
#[derive(Debug, Clone, Copy)]
pub enum KnownPixels<'a> {
    /// All pixels: colours times weights, and weights.
    All(&'a Tensor),
    /// Samples alone: weight 1 there, and 0 elsewhere.
    Samples(&'a Samples),
}

impl KnownPixels<'_> {
    /// Rows and columns.
    pub fn size(&self) -> [usize; 2] {
        match self {
            Self::All(map) => [map.height, map.width],
            Self::Samples(samples) => samples.size(),
        }
    }
}

/// Views `map`, of four channels, as weighted pixels.
pub fn pixels(map: &Tensor) -> &[PremulRgba] {
    map.data.as_chunks().0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_are_pixels_of_alpha_one_and_the_last_ones_again_beyond_the_border() {
        let mut frame = Frame::new(FrameSize { width: 3, height: 2 });
        frame.pixels_mut()[1] = [0.5, 2.0, -1.0, 1.0];
        frame.pixels_mut()[2] = [f32::NAN, 0.0, 0.0, 1.0];
        frame.pixels_mut()[5] = [0.25, 0.5, 0.75, 1.0];
        let mut samples = Samples::default();
        samples.gather(&frame, [4, 4]);
        assert_eq!(samples.size(), [4, 4]);
        assert_eq!(samples.row(0), [Sample { x: 1, colour: [0.5, 1.0, 0.0] }]);
        for y in 1..4 {
            assert_eq!(samples.row(y), [2, 3].map(|x| Sample { x, colour: [0.25, 0.5, 0.75] }));
        }
    }
}
