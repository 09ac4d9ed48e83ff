use crate::FrameSize;

/// Pixel position.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Pixel {
    /// Column, from the left.
    pub x: u16,
    /// Row, from the top.
    pub y: u16,
}

impl Pixel {
    /// Index of this pixel in a frame of `width` columns.
    #[inline]
    pub fn index(self, width: u32) -> usize {
        self.y as usize * width as usize + self.x as usize
    }
}

/// Compact list of the pixels to march, made from a mask by stream compaction.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SampleList {
    size: FrameSize,
    pixels: Vec<Pixel>,
}

impl SampleList {
    /// List of `pixels` in a frame of `size`.
    ///
    /// # Panics
    /// If a pixel lies outside the frame.
    pub fn new(size: FrameSize, pixels: Vec<Pixel>) -> Self {
        let inside = |p: &Pixel| u32::from(p.x) < size.width && u32::from(p.y) < size.height;
        assert!(pixels.iter().all(inside), "a pixel of the list lies outside the frame of {size}");
        Self { size, pixels }
    }

    /// Size of the frame.
    pub fn size(&self) -> FrameSize {
        self.size
    }

    /// Pixels in list order.
    pub fn pixels(&self) -> &[Pixel] {
        &self.pixels
    }

    /// Indices of the pixels in raster order, of equal pixels the last one only; `None` if the list is in this order.
    pub fn raster_order(&self) -> Option<Vec<usize>> {
        let pixels = &self.pixels;
        let place = |pixel: &Pixel| (pixel.y, pixel.x);
        if pixels.is_sorted_by(|a, b| place(a) < place(b)) {
            return None;
        }
        let mut order: Vec<usize> = (0..pixels.len()).collect();
        // Stable, so that the last of equal pixels stays the last.
        order.sort_by_key(|at| place(&pixels[*at]));
        let is_last = |at: usize| order.get(at + 1).is_none_or(|next| pixels[*next] != pixels[order[at]]);
        Some((0..order.len()).filter(|at| is_last(*at)).map(|at| order[at]).collect())
    }

    /// Number of pixels.
    pub fn len(&self) -> usize {
        self.pixels.len()
    }

    /// Whether the list is empty.
    pub fn is_empty(&self) -> bool {
        self.pixels.is_empty()
    }
}
