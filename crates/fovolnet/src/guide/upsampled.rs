use super::{GuidePixel, possible};
use fovol_core::{Frame, FrameSize, Pixel, Region};

/// Guide of every pixel of a region. Beyond it nothing is visible.
#[derive(Debug, Clone, PartialEq)]
pub struct UpsampledGuide {
    region: Region,
    /// How many times as bright as the guide a pixel can be: the light ratio is scaled to 0…1 by it.
    headroom: f32,
    pixels: Vec<GuidePixel>,
}

impl UpsampledGuide {
    /// Guide with the guide pixels `pixels` of `region`, row by row. Colours are at most `headroom` times as bright.
    ///
    /// # Panics
    /// If their number is not that of the region.
    pub fn new(region: Region, pixels: Vec<GuidePixel>, headroom: f32) -> Self {
        assert_eq!(pixels.len(), region.pixels(), "a guide pixel for every pixel of the region");
        Self { region, headroom, pixels }
    }

    /// Guide with another headroom.
    #[must_use]
    pub fn with_headroom(self, headroom: f32) -> Self {
        Self { headroom, ..self }
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
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_and_pixels_lie_within_the_region() {
        let region = Region { x: 4, y: 2, size: FrameSize { width: 4, height: 4 } };
        let pixels: Vec<GuidePixel> = (0..16).map(|i| [0.05 * i as f32; 4]).collect();
        let guide = UpsampledGuide::new(region, pixels.clone(), 1.0);
        assert_eq!(guide.row(3).unwrap(), &pixels[4..8]);
        assert!(guide.row(1).is_none() && guide.row(6).is_none());
        assert_eq!(guide.at(Pixel { x: 6, y: 5 }), Some(pixels[14]));
        assert_eq!(guide.at(Pixel { x: 3, y: 2 }), None);
    }
}
