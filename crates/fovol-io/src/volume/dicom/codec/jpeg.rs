//! JPEG: baseline, extended and lossless.

use super::{Decoded, check};
use crate::volume::dicom::pixel_format::{Photometric, PixelFormat};
use jpeg_decoder::{ColorTransform, Decoder, PixelFormat as Samples};

/// Unpacks the frame in `bytes`.
///
/// # Errors
/// Damaged frames, and those of another size or number of samples than `format`.
pub fn decode(bytes: &[u8], format: &PixelFormat) -> Result<Decoded, String> {
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
    let samples = match info.pixel_format {
        Samples::L8 | Samples::L16 => 1,
        Samples::RGB24 => 3,
        Samples::CMYK32 => 4,
    };
    check([usize::from(info.width), usize::from(info.height)], samples, format)?;
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
