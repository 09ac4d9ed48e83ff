//! Samples of a frame as lists, without the pixels between them.

use crate::cpu::tensor::Tensor;
use fovol_core::{FrameSize, SparseFrame};
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
    /// Collects the samples of `sparse` that are finite, with colours clamped to 0…1. Frames smaller than `height` × `width` are replicated at the right and
    /// bottom.
    pub fn gather(&mut self, sparse: &SparseFrame, [height, width]: [usize; 2]) {
        self.width = width;
        self.rows.resize_with(height, Vec::new);
        let FrameSize { width: columns, height: lines } = sparse.size();
        let (columns, lines) = (columns as usize, lines as usize);
        self.rows.par_iter_mut().enumerate().for_each(|(y, samples)| {
            let row = sparse.row(y.min(lines - 1));
            let (pixels, colours) = (&sparse.pixels()[row.clone()], &sparse.colours()[row]);
            samples.clear();
            // Growing vectors would take up to twice the memory.
            samples.reserve_exact(pixels.len());
            let is_finite = |colour: &[f32; 3]| colour.iter().all(|value| value.is_finite());
            let finite = pixels.iter().zip(colours).filter(|(_, colour)| is_finite(colour));
            samples.extend(finite.map(|(pixel, colour)| Sample {
                x: u32::from(pixel.x),
                colour: colour.map(|value| value.clamp(0.0, 1.0)),
            }));
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
    use fovol_core::Frame;

    #[test]
    fn samples_are_pixels_of_alpha_one_and_the_last_ones_again_beyond_the_border() {
        let mut frame = Frame::new(FrameSize { width: 3, height: 2 });
        frame.pixels_mut()[1] = [0.5, 2.0, -1.0, 1.0];
        frame.pixels_mut()[2] = [f32::NAN, 0.0, 0.0, 1.0];
        frame.pixels_mut()[5] = [0.25, 0.5, 0.75, 1.0];
        let mut samples = Samples::default();
        samples.gather(&SparseFrame::from(&frame), [4, 4]);
        assert_eq!(samples.size(), [4, 4]);
        assert_eq!(samples.row(0), [Sample { x: 1, colour: [0.5, 1.0, 0.0] }]);
        for y in 1..4 {
            assert_eq!(samples.row(y), [2, 3].map(|x| Sample { x, colour: [0.25, 0.5, 0.75] }));
        }
    }
}
