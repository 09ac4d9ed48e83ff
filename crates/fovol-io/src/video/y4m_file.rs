//! Uncompressed clips: 8-bit 4:4:4 y4m of limited range and BT.709.

use super::FrameRate;
use crate::atomic::Sink;
use crate::{Error, Result};
use fovol_core::memory::{self, Shortage};
use fovol_core::{Frame, FrameSize, stop};
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

/// Writes frames into a file. Nothing is held back: every write reports its own error.
pub(super) struct Writer(Box<y4m::Encoder<Sink<File>>>);

impl Writer {
    /// Begins a clip of frames of `size` in `file`.
    pub fn new(file: File, size: FrameSize, rate: FrameRate) -> io::Result<Self> {
        let ratio = y4m::Ratio::new(rate.numerator() as usize, rate.denominator() as usize);
        let encoder = y4m::encode(size.width as usize, size.height as usize, ratio)
            .with_colorspace(y4m::Colorspace::C444)
            .append_vendor_extension(
                y4m::VendorExtensionString::new(b"COLORRANGE=LIMITED".to_vec()).map_err(other)?,
            )
            .write_header(Sink(file));
        encoder.map(Box::new).map(Self).map_err(other)
    }

    /// Appends `frame`.
    pub fn push(&mut self, frame: &Frame) -> io::Result<()> {
        let [y, u, v] = planes(frame);
        self.0.write_frame(&y4m::Frame::new([&y, &u, &v], None)).map_err(other)
    }
}

/// The system's own error where there is one: it says what to do about a full disk.
fn other(error: y4m::Error) -> io::Error {
    match error {
        y4m::Error::IoError(error) => error,
        error => io::Error::other(error.to_string()),
    }
}

/// Reads frames one by one from a stream.
pub(super) struct Reader<R: Read> {
    path: PathBuf,
    size: FrameSize,
    decoder: y4m::Decoder<R>,
}

impl<R: Read> Reader<R> {
    /// Begins to read `from` a stream, which `path` names in errors.
    pub fn new(path: &Path, from: R) -> Result<Self> {
        // One frame of the largest size that is accepted.
        let limits = y4m::Limits { bytes: 3 << 28 };
        let decoder = y4m::Decoder::new_with_limits(from, limits).map_err(|e| damaged(path, &e))?;
        if !matches!(decoder.get_colorspace(), y4m::Colorspace::C444) {
            return Err(Error::unsupported(
                path,
                "only 8-bit 4:4:4 y4m clips are read; convert it with ffmpeg -pix_fmt yuv444p",
            ));
        }
        let side = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
        let size = FrameSize::new(side(decoder.get_width()), side(decoder.get_height()))
            .map_err(|e| Error::malformed(path, e.to_string()))?;
        Ok(Self { path: path.to_owned(), size, decoder })
    }

    /// The next frame; none at the end.
    pub fn next(&mut self) -> Result<Option<Frame>> {
        let Some(planes) = next_planes(&mut self.decoder, &self.path)? else { return Ok(None) };
        let frame =
            from_planes(self.size, [planes.get_y_plane(), planes.get_u_plane(), planes.get_v_plane()]);
        frame.map(Some).map_err(|shortage| Error::memory(&self.path, shortage))
    }

    /// Passes over the next frame; false at the end.
    pub fn skip(&mut self) -> Result<bool> {
        Ok(next_planes(&mut self.decoder, &self.path)?.is_some())
    }
}

fn next_planes<'a>(decoder: &'a mut y4m::Decoder<impl Read>, path: &Path) -> Result<Option<y4m::Frame<'a>>> {
    stop::point();
    match decoder.read_frame() {
        Ok(planes) => Ok(Some(planes)),
        Err(y4m::Error::EOF) => Ok(None),
        Err(e) => Err(damaged(path, &e)),
    }
}

fn damaged(path: &Path, error: &y4m::Error) -> Error {
    Error::malformed(path, format!("it is damaged ({error})"))
}

/// Advice for clips whose frames do not fit in memory.
const SMALLER_CLIP: &str = "scale the clip down with ffmpeg";

/// ITU-R BT.709 weights of red and blue in luma.
const RED: f32 = 0.2126;
const BLUE: f32 = 0.0722;

/// Limited-range BT.709 luma and chroma.
fn planes(frame: &Frame) -> [Vec<u8>; 3] {
    let mut planes = [(); 3].map(|()| Vec::with_capacity(frame.size().pixels()));
    for p in frame.pixels() {
        let [r, g, b] = [p[0], p[1], p[2]].map(|c| c.clamp(0.0, 1.0));
        let luma = RED * r + (1.0 - RED - BLUE) * g + BLUE * b;
        let (u, v) = ((b - luma) / (2.0 - 2.0 * BLUE), (r - luma) / (2.0 - 2.0 * RED));
        planes[0].push((16.0 + 219.0 * luma).round() as u8);
        planes[1].push((128.0 + 224.0 * u).round() as u8);
        planes[2].push((128.0 + 224.0 * v).round() as u8);
    }
    planes
}

/// The frame of `size` with luma and chroma in `planes`.
fn from_planes(size: FrameSize, [y, u, v]: [&[u8]; 3]) -> std::result::Result<Frame, Shortage> {
    let mut pixels = Vec::new();
    memory::reserve(&mut pixels, size.pixels(), "a frame of the clip", SMALLER_CLIP)?;
    pixels.extend(y.iter().zip(u).zip(v).map(|((&y, &u), &v)| {
        let luma = (f32::from(y) - 16.0) / 219.0;
        let (u, v) = ((f32::from(u) - 128.0) / 224.0, (f32::from(v) - 128.0) / 224.0);
        let (r, b) = (luma + v * (2.0 - 2.0 * RED), luma + u * (2.0 - 2.0 * BLUE));
        let g = (luma - RED * r - BLUE * b) / (1.0 - RED - BLUE);
        [r.clamp(0.0, 1.0), g.clamp(0.0, 1.0), b.clamp(0.0, 1.0), 1.0]
    }));
    Ok(Frame::from_pixels(size, pixels).expect("planes have the size of the frame"))
}
