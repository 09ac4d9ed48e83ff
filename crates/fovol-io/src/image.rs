//! Pictures in and out.

use crate::{Error, Result, atomic};
use exr::prelude::{WritableImage, read_first_rgba_layer_from_file};
use fovol_core::{Frame, FrameSize};
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageBuffer, ImageEncoder, ImageReader, Rgba, imageops};
use std::io::{BufRead, Cursor, Seek, Write};
use std::path::Path;

/// Whether a PNG keeps alpha.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Alpha {
    /// Opaque RGB.
    Drop,
    /// RGBA.
    Keep,
}

/// Writes `frame` as 8-bit PNG.
///
/// # Errors
/// What the system said.
pub fn write_png(path: &Path, frame: &Frame, alpha: Alpha) -> Result<()> {
    let (bytes, colour) = match alpha {
        Alpha::Drop => (frame.to_rgb8(), ExtendedColorType::Rgb8),
        Alpha::Keep => (frame.to_rgba8(), ExtendedColorType::Rgba8),
    };
    write_png_bytes(path, frame.size(), &bytes, colour)
}

/// Writes one byte per pixel, row by row, as grey PNG.
///
/// # Errors
/// What the system said.
pub fn write_grey_png(path: &Path, size: FrameSize, bytes: &[u8]) -> Result<()> {
    write_png_bytes(path, size, bytes, ExtendedColorType::L8)
}

fn write_png_bytes(path: &Path, size: FrameSize, bytes: &[u8], colour: ExtendedColorType) -> Result<()> {
    atomic::write(path, |out| {
        PngEncoder::new_with_quality(out, CompressionType::Fast, FilterType::Adaptive)
            .write_image(bytes, size.width, size.height, colour)
            .map_err(std::io::Error::other)
    })
}

/// Writes `frame` as EXR: RGBA of f32, the display values as they are.
///
/// # Errors
/// What the system said.
pub fn write_exr(path: &Path, frame: &Frame) -> Result<()> {
    let (width, height) = (frame.size().width as usize, frame.size().height as usize);
    let pixels = |at: exr::math::Vec2<usize>| {
        let [r, g, b, a] = frame.pixels()[at.y() * width + at.x()];
        (r, g, b, a)
    };
    let image = exr::image::Image::from_channels((width, height), exr::image::SpecificChannels::rgba(pixels));
    let mut bytes = Cursor::new(Vec::new());
    image.write().to_buffered(&mut bytes).map_err(|e| Error::io("write", path, std::io::Error::other(e)))?;
    atomic::write(path, |out| out.write_all(bytes.get_ref()))
}

/// `frame` at another size: cubic (Catmull and Rom), cut to 0…1.
///
/// # Panics
/// Never: frames have as many pixels as their sizes say.
#[must_use]
pub fn resized(frame: &Frame, size: FrameSize) -> Frame {
    let FrameSize { width, height } = frame.size();
    let picture = ImageBuffer::<Rgba<f32>, _>::from_raw(width, height, frame.pixels().as_flattened())
        .expect("frames have as many pixels as their sizes say");
    let resized = imageops::resize(&picture, size.width, size.height, imageops::FilterType::CatmullRom);
    let pixels = resized.pixels().map(|pixel| pixel.0).collect();
    Frame::from_pixels(size, pixels).expect("it has the size that was asked for")
}

/// Reads a PNG, JPEG, BMP or EXR picture as display values.
///
/// # Errors
/// A file that is missing, damaged, of another kind, or larger than a frame may be.
pub fn read(path: &Path) -> Result<Frame> {
    let is_exr = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("exr"));
    if is_exr { read_exr(path) } else { read_eight_bit(path) }
}

fn read_eight_bit(path: &Path) -> Result<Frame> {
    let file = std::fs::File::open(path).map_err(|e| Error::io("read", path, e))?;
    decode(path, std::io::BufReader::new(file))
}

/// The PNG, JPEG or BMP picture in `bytes`, which `path` names in errors.
///
/// # Errors
/// As [`read`].
pub fn decode(path: &Path, bytes: impl BufRead + Seek) -> Result<Frame> {
    let reader = ImageReader::new(bytes).with_guessed_format().map_err(|e| Error::io("read", path, e))?;
    let picture = reader
        .decode()
        .map_err(|e| {
            Error::malformed(
                path,
                format!("it is no picture that can be read ({e}); use PNG, JPEG, BMP or EXR"),
            )
        })?
        .into_rgba32f();
    let size = FrameSize::new(picture.width(), picture.height())
        .map_err(|e| Error::malformed(path, e.to_string()))?;
    let pixels = picture.pixels().map(|p| p.0).collect();
    Frame::from_pixels(size, pixels).map_err(|e| Error::malformed(path, e.to_string()))
}

fn read_exr(path: &Path) -> Result<Frame> {
    // The reader asks for the storage by a function without context; a damaged size is refused below.
    let result = read_first_rgba_layer_from_file(
        path,
        |size, _| (size, vec![[0.0f32; 4]; size.area()]),
        |(size, pixels): &mut (exr::math::Vec2<usize>, Vec<[f32; 4]>),
         at,
         (r, g, b, a): (f32, f32, f32, f32)| {
            pixels[at.y() * size.x() + at.x()] = [r, g, b, a];
        },
    );
    let image = result.map_err(|e| match e {
        exr::error::Error::Io(e) => Error::io("read", path, e),
        e => Error::malformed(path, format!("it is no EXR picture with red, green and blue ({e})")),
    })?;
    let (size, pixels) = image.layer_data.channel_data.pixels;
    let side = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
    let size =
        FrameSize::new(side(size.x()), side(size.y())).map_err(|e| Error::malformed(path, e.to_string()))?;
    Frame::from_pixels(size, pixels).map_err(|e| Error::malformed(path, e.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame() -> Frame {
        let size = FrameSize::new(5, 3).unwrap();
        let pixels = (0..15).map(|i| [i as f32 / 14.0, 0.2, 1.0 - i as f32 / 20.0, (i % 2) as f32]).collect();
        Frame::from_pixels(size, pixels).unwrap()
    }

    #[test]
    fn another_size_keeps_what_is_linear() {
        let size = FrameSize::new(16, 12).unwrap();
        let ramp =
            (0..16 * 12).map(|i| [(i % 16) as f32 / 16.0, (i / 16) as f32 / 16.0, 0.25, 1.0]).collect();
        let larger = resized(&Frame::from_pixels(size, ramp).unwrap(), FrameSize::new(32, 24).unwrap());
        for (x, y) in [(8, 8), (20, 11), (15, 17)] {
            // Centres of pixels are in the middle of them.
            let place = |at: u32| ((at as f32 + 0.5) / 2.0 - 0.5) / 16.0;
            let (expected, found) = ([place(x), place(y), 0.25, 1.0], larger.pixel(x, y));
            assert!((0..4).all(|c| (found[c] - expected[c]).abs() < 1e-4), "{found:?} {expected:?}");
        }
    }

    #[test]
    fn png_keeps_eight_bits_and_exr_everything() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        write_png(&path, &frame(), Alpha::Keep).unwrap();
        assert_eq!(read(&path).unwrap().to_rgba8(), frame().to_rgba8());
        write_png(&path, &frame(), Alpha::Drop).unwrap();
        assert_eq!(read(&path).unwrap().to_rgb8(), frame().to_rgb8());
        let path = folder.path().join("a.exr");
        let mut bright = frame();
        bright.pixels_mut()[0] = [-0.5, 3.0, 0.25, 1.0];
        write_exr(&path, &bright).unwrap();
        assert_eq!(read(&path).unwrap(), bright);
    }

    #[test]
    fn what_is_no_picture_is_said_so() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["x.png", "x.exr", "x"] {
            let path = folder.path().join(name);
            assert!(read(&path).unwrap_err().to_string().contains("check the path"), "{name}");
            std::fs::write(&path, b"no picture at all").unwrap();
            assert!(read(&path).is_err(), "{name}");
        }
    }
}
