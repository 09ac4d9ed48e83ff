//! Pictures in and out.

mod channels;
mod exr_file;
mod picture;
mod resized;

pub use picture::{Motion, Picture};
pub use resized::resized;

use crate::{Error, Result, atomic};
use fovol_core::{Frame, FrameSize, input};
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder, ImageReader};
use std::fs::File;
use std::io::{BufRead, BufReader, Read, Seek};
use std::path::Path;

/// File extensions of supported images.
pub const EXTENSIONS: [&str; 5] = ["png", "exr", "jpg", "jpeg", "bmp"];

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
/// Errors of the operating system.
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
/// Errors of the operating system.
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

/// Writes `frame` as EXR: RGBA of f32, with unconverted display values. Equal pixels give equal bytes.
///
/// # Errors
/// Errors of the operating system.
pub fn write_exr(path: &Path, frame: &Frame) -> Result<()> {
    let bytes = exr_file::encode(frame).map_err(|e| Error::io("write", path, std::io::Error::other(e)))?;
    atomic::write_bytes(path, &bytes)
}

/// Reads a PNG, JPEG, BMP or EXR image as display values. An EXR image has the size of its display window.
///
/// # Errors
/// A file that is missing, damaged, of another kind, or larger than a frame may be.
pub fn read(path: &Path) -> Result<Frame> {
    read_picture(path).map(|picture| picture.frame)
}

/// Reads an image and its metadata.
///
/// # Errors
/// Those of [`read`].
pub fn read_picture(path: &Path) -> Result<Picture> {
    if is_exr(path)? { exr_file::read(path) } else { picture(path, BufReader::new(open(path)?)) }
}

/// Reads the size of the image at `path`, but not its pixels.
///
/// # Errors
/// Those of [`read`].
pub fn size(path: &Path) -> Result<FrameSize> {
    if is_exr(path)? {
        return exr_file::size(path);
    }
    let reader = ImageReader::new(BufReader::new(open(path)?)).with_guessed_format();
    let size = reader.map_err(|e| Error::io("read", path, e))?.into_dimensions();
    let (width, height) = size.map_err(|e| no_picture(path, &e))?;
    FrameSize::new(width, height).map_err(|e| Error::malformed(path, e.to_string()))
}

/// Reads the motion of a frame from an EXR file: two channels whose names differ by X and Y, by U and V, or by R and G.
///
/// # Errors
/// Those of [`read`], or a file without such channels.
pub fn read_motion(path: &Path) -> Result<Motion> {
    if !is_exr(path)? {
        return Err(Error::unsupported(
            path,
            "motion is read from EXR files, which this is not; write it as EXR",
        ));
    }
    exr_file::read_motion(path)
}

fn open(path: &Path) -> Result<File> {
    input::open(path).map_err(|e| Error::io("read", path, e))
}

/// Whether the file at `path` begins as EXR files do, or is called like one.
fn is_exr(path: &Path) -> Result<bool> {
    let mut magic = [0; 4];
    let begins = open(path)?.read_exact(&mut magic).is_ok() && magic == exr_file::MAGIC;
    let is_other = image::guess_format(&magic).is_ok();
    Ok(begins || (!is_other && path.extension().is_some_and(|e| e.eq_ignore_ascii_case("exr"))))
}

fn no_picture(path: &Path, error: &image::ImageError) -> Error {
    Error::malformed(path, format!("it is no picture that can be read ({error}); use PNG, JPEG, BMP or EXR"))
}

/// Decodes the PNG, JPEG or BMP image in `bytes`; errors name `path`.
///
/// # Errors
/// Those of [`read`].
pub fn decode(path: &Path, bytes: impl BufRead + Seek) -> Result<Frame> {
    picture(path, bytes).map(|picture| picture.frame)
}

fn picture(path: &Path, bytes: impl BufRead + Seek) -> Result<Picture> {
    let reader = ImageReader::new(bytes).with_guessed_format().map_err(|e| Error::io("read", path, e))?;
    let picture = reader.decode().map_err(|e| no_picture(path, &e))?;
    let has_alpha = picture.color().has_alpha();
    let picture = picture.into_rgba32f();
    let size = FrameSize::new(picture.width(), picture.height())
        .map_err(|e| Error::malformed(path, e.to_string()))?;
    let pixels = picture.pixels().map(|p| p.0).collect();
    let frame = Frame::from_pixels(size, pixels).map_err(|e| Error::malformed(path, e.to_string()))?;
    Ok(Picture { frame, has_alpha, notes: Vec::new() })
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
