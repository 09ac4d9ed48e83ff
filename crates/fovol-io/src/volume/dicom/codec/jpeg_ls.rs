//! JPEG-LS, by CharLS, which is a cargo feature of its own.

use super::decoded::Decoded;
use crate::volume::dicom::pixel_format::PixelFormat;

/// Unpacks the frame in `bytes`.
///
/// # Errors
/// Always: the feature is off.
#[cfg(not(feature = "jpeg-ls"))]
pub fn decode(_bytes: &[u8], _format: &PixelFormat) -> Result<Decoded, String> {
    Err("it is compressed by JPEG-LS, for which this program is built without the cargo feature `jpeg-ls`; unpack it with `gdcmconv --raw IN OUT`".into())
}

/// Unpacks the frame in `bytes`.
///
/// # Errors
/// Damaged frames, and those of another size or number of samples than `format`.
#[cfg(feature = "jpeg-ls")]
pub fn decode(bytes: &[u8], format: &PixelFormat) -> Result<Decoded, String> {
    let (size, samples) = stated(bytes).ok_or("its JPEG-LS is damaged; copy or download it again")?;
    super::decoded::check(size, samples, format)?;
    let mut pixels = charls::CharLS::default()
        .decode(bytes)
        .map_err(|e| format!("its JPEG-LS cannot be unpacked ({e}); copy or download it again"))?;
    if pixels.len() == format.values() && format.sample_size() == 2 {
        pixels = pixels.iter().flat_map(|&byte| [byte, 0]).collect();
    }
    if pixels.len() != format.values() * format.sample_size() {
        return Err("its JPEG-LS has other bits than its header says; mend its header".into());
    }
    Ok(Decoded { bytes: pixels, is_rgb: false })
}

/// Size and number of samples of a frame, before any memory is taken for it.
#[cfg(feature = "jpeg-ls")]
fn stated(bytes: &[u8]) -> Option<([usize; 2], usize)> {
    let at = bytes.windows(2).position(|pair| pair == [0xFF, 0xF7])?;
    let head = bytes.get(at + 2..at + 10)?;
    let two = |at: usize| usize::from(u16::from_be_bytes([head[at], head[at + 1]]));
    Some(([two(5), two(3)], usize::from(head[7])))
}
