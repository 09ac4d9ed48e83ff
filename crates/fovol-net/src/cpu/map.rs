/// An image of any number of channels: \[row\]\[column\]\[channel\].
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Map {
    /// The numbers, channels together.
    pub data: Vec<f32>,
    /// Rows.
    pub height: usize,
    /// Columns.
    pub width: usize,
    /// Numbers per pixel.
    pub channels: usize,
}

impl Map {
    /// Zeros.
    pub fn zeros(height: usize, width: usize, channels: usize) -> Self {
        Self { data: vec![0.0; height * width * channels], height, width, channels }
    }

    /// The numbers of row `y`.
    #[inline]
    pub fn row(&self, y: usize) -> &[f32] {
        let length = self.width * self.channels;
        &self.data[y * length..(y + 1) * length]
    }

    /// The numbers of a pixel.
    #[inline]
    pub fn pixel(&self, y: usize, x: usize) -> &[f32] {
        let start = (y * self.width + x) * self.channels;
        &self.data[start..start + self.channels]
    }

    /// One number, 0 beyond the border.
    #[inline]
    pub fn or_zero(&self, y: isize, x: isize, c: usize) -> f32 {
        let inside = y >= 0 && x >= 0 && (y as usize) < self.height && (x as usize) < self.width;
        if inside { self.pixel(y as usize, x as usize)[c] } else { 0.0 }
    }
}
