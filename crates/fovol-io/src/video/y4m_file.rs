//! Uncompressed clips: 8-bit 4:4:4 y4m of limited range and BT.709.

use super::FrameRate;
use crate::atomic::Sink;
use crate::{Error, Result};
use fovol_core::{Frame, FrameSize, stop};
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

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

/// Reads all frames `from` a stream, which `path` names in errors.
pub(super) fn read(path: &Path, from: impl Read) -> Result<Vec<Frame>> {
    let bad = |e: y4m::Error| Error::malformed(path, format!("it is damaged ({e})"));
    // One frame of the largest size that is accepted.
    let limits = y4m::Limits { bytes: 3 << 28 };
    let mut decoder = y4m::Decoder::new_with_limits(from, limits).map_err(bad)?;
    if !matches!(decoder.get_colorspace(), y4m::Colorspace::C444) {
        return Err(Error::unsupported(
            path,
            "only 8-bit 4:4:4 y4m clips are read; convert it with ffmpeg -pix_fmt yuv444p",
        ));
    }
    let side = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
    let size = FrameSize::new(side(decoder.get_width()), side(decoder.get_height()))
        .map_err(|e| Error::malformed(path, e.to_string()))?;
    let mut frames = Vec::new();
    loop {
        stop::point();
        match decoder.read_frame() {
            Ok(frame) => {
                frames.push(from_planes(size, frame.get_y_plane(), frame.get_u_plane(), frame.get_v_plane()));
            }
            Err(y4m::Error::EOF) => return Ok(frames),
            Err(e) => return Err(bad(e)),
        }
    }
}

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

fn from_planes(size: FrameSize, y: &[u8], u: &[u8], v: &[u8]) -> Frame {
    let pixels = y.iter().zip(u).zip(v).map(|((&y, &u), &v)| {
        let luma = (f32::from(y) - 16.0) / 219.0;
        let (u, v) = ((f32::from(u) - 128.0) / 224.0, (f32::from(v) - 128.0) / 224.0);
        let (r, b) = (luma + v * (2.0 - 2.0 * RED), luma + u * (2.0 - 2.0 * BLUE));
        let g = (luma - RED * r - BLUE * b) / (1.0 - RED - BLUE);
        [r.clamp(0.0, 1.0), g.clamp(0.0, 1.0), b.clamp(0.0, 1.0), 1.0]
    });
    Frame::from_pixels(size, pixels.collect()).expect("planes have the size of the frame")
}
