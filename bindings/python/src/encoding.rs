//! Pictures as bytes for a browser.

use crate::errors::wrong;
use fovolnet::core::Frame;
use image::codecs::jpeg::JpegEncoder;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder, ImageResult};
use pyo3::PyResult;

/// How the bytes of a picture are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Encoding {
    /// Errors and size depend on the quality, 1 to 100. Smaller than PNG where the picture has grain, but slower.
    Jpeg(u8),
    /// Larger and exact.
    Png,
    /// Red, green, blue and an opaque alpha of each pixel: what a canvas takes, and the fastest for small pictures.
    Raw,
}

impl Encoding {
    /// The encoding called `name`.
    ///
    /// # Errors
    /// Another name than `jpeg`, `png` or `raw`; a quality outside 1 to 100.
    pub fn named(name: &str, quality: u8) -> PyResult<Self> {
        match name {
            "jpeg" if (1..=100).contains(&quality) => Ok(Self::Jpeg(quality)),
            "jpeg" => Err(wrong(format!("the quality of JPEG is 1 to 100, not {quality}"))),
            "png" => Ok(Self::Png),
            "raw" => Ok(Self::Raw),
            _ => Err(wrong(format!("pictures are encoded as jpeg, png or raw, not {name}"))),
        }
    }

    /// `frame` without its opacity, encoded.
    ///
    /// # Errors
    /// Frames that are too large for the format.
    pub fn of(self, frame: &Frame) -> ImageResult<Vec<u8>> {
        let (width, height) = (frame.size().width, frame.size().height);
        let mut bytes = Vec::new();
        match self {
            Self::Jpeg(quality) => {
                let rgb = frame.to_rgb8();
                JpegEncoder::new_with_quality(&mut bytes, quality).encode(
                    &rgb,
                    width,
                    height,
                    ExtendedColorType::Rgb8,
                )?;
            }
            Self::Png => {
                let encoder =
                    PngEncoder::new_with_quality(&mut bytes, CompressionType::Fast, FilterType::Adaptive);
                encoder.write_image(&frame.to_rgb8(), width, height, ExtendedColorType::Rgb8)?;
            }
            Self::Raw => {
                bytes = frame.to_rgba8();
                bytes.chunks_exact_mut(4).for_each(|pixel| pixel[3] = u8::MAX);
            }
        }
        Ok(bytes)
    }
}
