//! JPEG 2000, lossless or not.

use super::decoded::{Decoded, check};
use crate::volume::dicom::pixel_format::PixelFormat;
use hayro_jpeg2000::{DecodeSettings, DecoderContext, Image};

/// Unpacks the frame in `bytes`.
///
/// # Errors
/// Damaged frames, and those of another size or number of samples than `format`.
pub fn decode(bytes: &[u8], format: &PixelFormat) -> Result<Decoded, String> {
    let damaged = |e| format!("its JPEG 2000 cannot be unpacked ({e}); copy or download it again");
    let settings = DecodeSettings { resolve_palette_indices: false, strict: false, target_resolution: None };
    let image = Image::new(bytes, &settings).map_err(damaged)?;
    let size = [image.width() as usize, image.height() as usize];
    check(size, format.samples, format)?;
    let mut context = DecoderContext::default();
    let decoded = image.decode(&mut context).map_err(damaged)?;
    let components = decoded.components();
    check(size, components.len(), format)?;
    // The decoder shifts signed samples as if they were unsigned.
    let shift =
        if is_signed(bytes) { -(1i64 << image.original_bit_depth().saturating_sub(1).min(31)) } else { 0 };
    let bytes = format.sample_size();
    let mut out = vec![0; format.values() * bytes];
    for (number, component) in components.iter().enumerate() {
        let places = out.chunks_exact_mut(bytes).skip(number).step_by(format.samples);
        for (place, &sample) in places.zip(component.samples()) {
            let whole = sample.round() as i64 + shift;
            place.copy_from_slice(&whole.to_le_bytes()[..bytes]);
        }
    }
    Ok(Decoded { bytes: out, is_rgb: true })
}

/// Whether the first component of a code stream is signed: the mark of its size is followed by 38 bytes of numbers.
fn is_signed(bytes: &[u8]) -> bool {
    const START: [u8; 4] = [0xFF, 0x4F, 0xFF, 0x51];
    let start = bytes.windows(START.len()).position(|four| four == START);
    start.and_then(|start| bytes.get(start + 42)).is_some_and(|&depth| depth & 0x80 != 0)
}
