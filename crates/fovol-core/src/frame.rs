use crate::{Error, Result};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// Largest width or height of a frame, in pixels.
pub const MAX_FRAME_SIDE: u32 = 32_768;

/// Width and height of a frame in pixels, 1…32768 each.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(try_from = "[u32; 2]", into = "[u32; 2]")]
pub struct FrameSize {
    /// Pixels along x.
    pub width: u32,
    /// Pixels along y.
    pub height: u32,
}

impl FrameSize {
    /// Size of `width` × `height` pixels.
    ///
    /// # Errors
    /// A side of 0 or above [`MAX_FRAME_SIDE`].
    pub fn new(width: u32, height: u32) -> Result<Self> {
        if width == 0 || height == 0 || width > MAX_FRAME_SIDE || height > MAX_FRAME_SIDE {
            return Err(Error::Extent {
                what: "frame size".into(),
                found: format!("{width}x{height}"),
                expected: format!("1 to {MAX_FRAME_SIDE} pixels along each side"),
            });
        }
        Ok(Self { width, height })
    }

    /// Number of pixels.
    pub fn pixels(self) -> usize {
        self.width as usize * self.height as usize
    }
}

impl Default for FrameSize {
    fn default() -> Self {
        Self { width: 1280, height: 720 }
    }
}

impl TryFrom<[u32; 2]> for FrameSize {
    type Error = Error;

    fn try_from([width, height]: [u32; 2]) -> Result<Self> {
        Self::new(width, height)
    }
}

impl From<FrameSize> for [u32; 2] {
    fn from(size: FrameSize) -> Self {
        [size.width, size.height]
    }
}

impl fmt::Display for FrameSize {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}x{}", self.width, self.height)
    }
}

impl FromStr for FrameSize {
    type Err = String;

    /// Parses a size such as `1280x720`.
    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let bad = || format!("`{text}` is no frame size; write WIDTHxHEIGHT, as in 1280x720");
        let (w, h) = text.split_once(['x', 'X', '×']).ok_or_else(bad)?;
        let side = |s: &str| s.trim().parse::<u32>().map_err(|_| bad());
        Self::new(side(w)?, side(h)?).map_err(|e| e.to_string())
    }
}

/// Picture of display values: RGBA as f32, row 0 on top.
///
/// In a sparse frame alpha is 1 at sampled pixels and 0 elsewhere. In a full frame it is 1 everywhere.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame {
    size: FrameSize,
    pixels: Vec<[f32; 4]>,
}

impl Frame {
    /// Frame of transparent black.
    pub fn new(size: FrameSize) -> Self {
        Self { size, pixels: vec![[0.0; 4]; size.pixels()] }
    }

    /// Frame from `pixels`, row by row.
    ///
    /// # Errors
    /// A number of pixels other than width × height.
    pub fn from_pixels(size: FrameSize, pixels: Vec<[f32; 4]>) -> Result<Self> {
        if pixels.len() != size.pixels() {
            return Err(Error::Extent {
                what: "number of pixels".into(),
                found: pixels.len().to_string(),
                expected: format!("{} for a frame of {size}", size.pixels()),
            });
        }
        Ok(Self { size, pixels })
    }

    /// Width and height.
    pub fn size(&self) -> FrameSize {
        self.size
    }

    /// Pixels, row by row.
    pub fn pixels(&self) -> &[[f32; 4]] {
        &self.pixels
    }

    /// Takes the pixels, row by row.
    pub fn into_pixels(self) -> Vec<[f32; 4]> {
        self.pixels
    }

    /// Mutable pixels, row by row.
    pub fn pixels_mut(&mut self) -> &mut [[f32; 4]] {
        &mut self.pixels
    }

    /// Pixel at column `x` of row `y`.
    ///
    /// # Panics
    /// If the pixel lies outside the frame.
    pub fn pixel(&self, x: u32, y: u32) -> [f32; 4] {
        assert!(x < self.size.width, "column {x} outside a frame of {}", self.size);
        self.pixels[y as usize * self.size.width as usize + x as usize]
    }

    /// Sets every pixel to `value`.
    pub fn fill(&mut self, value: [f32; 4]) {
        self.pixels.fill(value);
    }

    /// Multiplies colours by alpha, for formats that store premultiplied alpha.
    #[must_use]
    pub fn premultiplied(mut self) -> Self {
        for pixel in &mut self.pixels {
            let [r, g, b, a] = *pixel;
            *pixel = [r * a, g * a, b * a, a];
        }
        self
    }

    /// Converts to 8-bit opaque RGB: round(255 · clamp(c, 0, 1)) per channel.
    pub fn to_rgb8(&self) -> Vec<u8> {
        self.quantised(|[r, g, b, _]| [r, g, b])
    }

    /// Converts to 8-bit RGBA, each channel as in [`Self::to_rgb8`].
    pub fn to_rgba8(&self) -> Vec<u8> {
        self.quantised(|pixel| pixel)
    }

    /// The channels that `keep` keeps of every pixel, as 8 bits.
    fn quantised<const N: usize>(&self, keep: impl Fn([u8; 4]) -> [u8; N] + Sync) -> Vec<u8> {
        /// Pixels that one thread converts at a time: fewer are not worth waking another.
        const PIXELS: usize = 1 << 15;
        let mut bytes = vec![0; N * self.pixels.len()];
        bytes.par_chunks_mut(N * PIXELS).zip(self.pixels.par_chunks(PIXELS)).for_each(|(bytes, pixels)| {
            for (bytes, pixels) in bytes.chunks_mut(N * BLOCK).zip(pixels.chunks(BLOCK)) {
                let block = quantise(pixels);
                for (byte, pixel) in bytes.as_chunks_mut::<N>().0.iter_mut().zip(block) {
                    *byte = keep(pixel);
                }
            }
        });
        bytes
    }
}

/// Pixels quantised at a time: all four channels of a block fill vectors.
const BLOCK: usize = 32;

/// Quantises up to [`BLOCK`] pixels to 8 bits: round(255 · clamp(c, 0, 1)); NaN becomes 0.
#[inline]
fn quantise(pixels: &[[f32; 4]]) -> [[u8; 4]; BLOCK] {
    /// Added to a number from 0 to 255, it rounds it to the nearest integer, which is then in the lowest bits. Vectors of every
    /// processor can do that; conversions that saturate, and `round`, are slow.
    const ROUNDS: f32 = 8_388_608.0;
    #[expect(clippy::manual_clamp, reason = "`max` maps NaN to 0")]
    let channel = |c: f32| {
        let c = c.max(0.0).min(1.0) * 255.0;
        let nearest = (c + ROUNDS) - ROUNDS;
        // Halves went to the even neighbour.
        let rounded = if c - nearest >= 0.5 { nearest + 1.0 } else { nearest };
        (rounded + ROUNDS).to_bits() as u8
    };
    let mut bytes = [[0; 4]; BLOCK];
    for (bytes, pixel) in bytes.iter_mut().zip(pixels) {
        *bytes = pixel.map(channel);
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_read_as_written() {
        assert_eq!("1280x720".parse(), Ok(FrameSize { width: 1280, height: 720 }));
        for bad in ["0x1", "100000x1", "12", "x", "-1x5", "1280x720x3", ""] {
            assert!(bad.parse::<FrameSize>().is_err(), "{bad}");
        }
    }

    #[test]
    fn quantisation_rounds_and_saturates() {
        let size = FrameSize::new(2, 1).unwrap();
        let frame =
            Frame::from_pixels(size, vec![[0.5, -1.0, 2.0, 1.0], [f32::NAN, 0.498, 0.0, 1.0]]).unwrap();
        assert_eq!(frame.to_rgb8(), [128, 0, 255, 0, 127, 0]);
        assert_eq!(frame.to_rgba8(), [128, 0, 255, 255, 0, 127, 0, 255]);
    }

    #[test]
    fn quantisation_is_that_of_plain_code() {
        let plain = |c: f32| (c.clamp(0.0, 1.0) * 255.0).round() as u8;
        // Numbers of all sizes, and those next to halves, on more pixels than one thread takes.
        let spread = (0..1 << 18).map(|i| f32::from_bits(i * 16_411));
        let halves = (0..255).flat_map(|i| {
            let half = (f32::from(i as u8) + 0.5) / 255.0;
            [half.next_down(), half, half.next_up()]
        });
        let mut numbers: Vec<f32> = spread.chain(halves).collect();
        numbers.resize(numbers.len().next_multiple_of(4), -0.0);
        let pixels: Vec<[f32; 4]> = numbers.as_chunks().0.to_vec();
        let size = FrameSize::new(4, (pixels.len() / 4) as u32).unwrap();
        let pixels = pixels[..size.pixels()].to_vec();
        let frame = Frame::from_pixels(size, pixels.clone()).unwrap();
        let expected: Vec<u8> = pixels.iter().flatten().copied().map(plain).collect();
        assert!(frame.to_rgba8() == expected);
        let opaque: Vec<u8> = pixels.iter().flat_map(|[r, g, b, _]| [*r, *g, *b]).map(plain).collect();
        assert!(frame.to_rgb8() == opaque);
    }
}
