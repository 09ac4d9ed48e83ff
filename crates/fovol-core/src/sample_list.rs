use crate::FrameSize;

/// One pixel position.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Pixel {
    /// Column, from the left.
    pub x: u16,
    /// Row, from the top.
    pub y: u16,
}

impl Pixel {
    /// The position of this pixel in a frame that is `width` wide.
    #[inline]
    pub fn index(self, width: u32) -> usize {
        self.y as usize * width as usize + self.x as usize
    }
}

/// The pixels to march, packed: what stream compaction makes of a mask.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SampleList {
    size: FrameSize,
    pixels: Vec<Pixel>,
}

impl SampleList {
    /// The list of `pixels` in a frame of `size`.
    ///
    /// # Panics
    /// When a pixel lies outside the frame.
    pub fn new(size: FrameSize, pixels: Vec<Pixel>) -> Self {
        let inside = |p: &Pixel| u32::from(p.x) < size.width && u32::from(p.y) < size.height;
        assert!(pixels.iter().all(inside), "a pixel of the list lies outside the frame of {size}");
        Self { size, pixels }
    }

    /// The size of the frame.
    pub fn size(&self) -> FrameSize {
        self.size
    }

    /// The pixels, in list order.
    pub fn pixels(&self) -> &[Pixel] {
        &self.pixels
    }

    /// How many pixels there are.
    pub fn len(&self) -> usize {
        self.pixels.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.pixels.is_empty()
    }
}
