//! JPEG: baseline, extended and lossless.

use super::decoded::{Decoded, check};
use crate::volume::dicom::pixel_format::{Photometric, PixelFormat};
use jpeg_decoder::{ColorTransform, Decoder, PixelFormat as Samples};

/// Unpacks the frame in `bytes`.
///
/// # Errors
/// Damaged frames, and those of another size or number of samples than `format`.
pub fn decode(bytes: &[u8], format: &PixelFormat) -> Result<Decoded, String> {
    // The decoder takes memory, and panics at two samples, before it can be asked.
    let frame = frame_header(bytes).ok_or("its JPEG has no picture; copy or download it again")?;
    check(frame.size, frame.samples, format)?;
    if frame.bits > 8 && !frame.is_lossless {
        return Err(format!(
            "its JPEG is lossy with {} bits, which is not read; try `gdcmconv --raw IN OUT`",
            frame.bits
        ));
    }
    let damaged =
        |e: jpeg_decoder::Error| format!("its JPEG cannot be unpacked ({e}); try `gdcmconv --raw IN OUT`");
    let mut decoder = Decoder::new(bytes);
    decoder.set_max_decoding_buffer_size(format.values().saturating_mul(2));
    if format.samples == 3 {
        decoder.set_color_transform(match format.photometric {
            Photometric::Rgb => ColorTransform::RGB,
            _ => ColorTransform::YCbCr,
        });
    }
    decoder.read_info().map_err(damaged)?;
    let info = decoder.info().ok_or("its JPEG has no picture; copy or download it again")?;
    let pixels = decoder.decode().map_err(damaged)?;
    Ok(Decoded { bytes: resized(pixels, info.pixel_format, format)?, is_rgb: true })
}

/// `pixels` in the size of the format's samples, little-endian.
fn resized(pixels: Vec<u8>, found: Samples, format: &PixelFormat) -> Result<Vec<u8>, String> {
    let size = format.sample_size();
    let bytes: Vec<u8> = match (found, size) {
        (Samples::L16, 2) => pixels
            .chunks_exact(2)
            .flat_map(|two| u16::from_ne_bytes([two[0], two[1]]).to_le_bytes())
            .collect(),
        (Samples::L16, _) => {
            return Err("its JPEG has more bits than its header says; mend its header".into());
        }
        (_, 1) => pixels,
        (_, size) => pixels.iter().flat_map(|&byte| std::iter::once(byte).chain(vec![0; size - 1])).collect(),
    };
    match bytes.len() == format.values() * size {
        true => Ok(bytes),
        false => Err("its JPEG ends early; copy or download it again".into()),
    }
}

/// What the header of a JPEG's frame says.
struct FrameHeader {
    size: [usize; 2],
    samples: usize,
    bits: u8,
    is_lossless: bool,
}

/// The header of the frame in `bytes`, which are segments of a mark, a length and as many bytes.
fn frame_header(bytes: &[u8]) -> Option<FrameHeader> {
    let two = |at: usize| Some(usize::from(u16::from_be_bytes([*bytes.get(at)?, *bytes.get(at + 1)?])));
    let mut at = 2;
    loop {
        let (0xFF, kind) = (*bytes.get(at)?, *bytes.get(at + 1)?) else { return None };
        match kind {
            // Marks may be padded.
            0xFF => at += 1,
            0xC4 | 0xC8 | 0xCC => at += 2 + two(at + 2)?,
            0xC0..=0xCF => {
                return Some(FrameHeader {
                    size: [two(at + 7)?, two(at + 5)?],
                    samples: usize::from(*bytes.get(at + 9)?),
                    bits: *bytes.get(at + 4)?,
                    is_lossless: matches!(kind, 0xC3 | 0xC7 | 0xCB | 0xCF),
                });
            }
            _ => at += 2 + two(at + 2)?,
        }
    }
}
