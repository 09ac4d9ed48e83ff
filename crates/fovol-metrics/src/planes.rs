use fovol_core::Frame;

/// RGB display values of one pixel, clamped to [0, 1]; NaN becomes 0.
#[inline]
pub(crate) fn display(pixel: [f32; 4]) -> [f32; 3] {
    [0, 1, 2].map(|c| if pixel[c].is_nan() { 0.0 } else { pixel[c].clamp(0.0, 1.0) })
}

/// One colour channel of a frame, row by row.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Plane {
    pub width: usize,
    pub height: usize,
    pub values: Vec<f32>,
}

impl Plane {
    /// Channel `c` (0 red, 1 green, 2 blue) of `frame`.
    pub fn channel(frame: &Frame, c: usize) -> Self {
        let size = frame.size();
        let values = frame.pixels().iter().map(|&p| display(p)[c]).collect();
        Self { width: size.width as usize, height: size.height as usize, values }
    }

    pub fn row(&self, y: usize) -> &[f32] {
        &self.values[y * self.width..(y + 1) * self.width]
    }

    /// Downsamples to half the size by averages of 2×2 pixels.
    ///
    /// As in pytorch-msssim, odd sides are padded by a line of zeros in front. So the first line of the result is
    /// half as bright, in both pictures alike.
    pub fn halved(&self) -> Self {
        let (width, height) = (self.width.div_ceil(2), self.height.div_ceil(2));
        let (odd_x, odd_y) = (self.width % 2, self.height % 2);
        let at = |x: usize, y: usize| {
            // Indices of the padding wrap below zero and exceed the size.
            if x < self.width && y < self.height { self.values[y * self.width + x] } else { 0.0 }
        };
        let mut values = Vec::with_capacity(width * height);
        for y in (0..height).map(|y| (2 * y).wrapping_sub(odd_y)) {
            for x in (0..width).map(|x| (2 * x).wrapping_sub(odd_x)) {
                let (right, below) = (x.wrapping_add(1), y.wrapping_add(1));
                values.push((at(x, y) + at(right, y) + at(x, below) + at(right, below)) * 0.25);
            }
        }
        Self { width, height, values }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halving_averages_and_pads_odd_sides_in_front() {
        let even = Plane { width: 4, height: 2, values: vec![1.0, 3.0, 0.0, 0.0, 5.0, 7.0, 0.0, 8.0] };
        assert_eq!(even.halved(), Plane { width: 2, height: 1, values: vec![4.0, 2.0] });
        let odd = Plane { width: 3, height: 1, values: vec![4.0, 8.0, 16.0] };
        assert_eq!(odd.halved(), Plane { width: 2, height: 1, values: vec![1.0, 6.0] });
    }
}
