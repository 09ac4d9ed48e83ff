//! Codecs of single frames.

mod jpeg;
mod jpeg2000;
mod jpeg_ls;
mod rle;

use super::pixel_format::PixelFormat;
use super::syntax::Codec;

/// Samples of one frame.
pub struct Decoded {
    /// Little-endian samples of the format's size, interleaved.
    pub bytes: Vec<u8>,
    /// Whether colours are red, green and blue by now.
    pub is_rgb: bool,
}

/// Unpacks the frame in `bytes`.
///
/// # Errors
/// Damaged frames, and features that are not read, in words.
pub fn decode(codec: Codec, bytes: &[u8], format: &PixelFormat) -> Result<Decoded, String> {
    match codec {
        Codec::Rle => rle::decode(bytes, format),
        Codec::Jpeg => jpeg::decode(bytes, format),
        Codec::JpegLs => jpeg_ls::decode(bytes, format),
        Codec::Jpeg2000 => jpeg2000::decode(bytes, format),
        Codec::None => Ok(Decoded { bytes: bytes.to_vec(), is_rgb: false }),
    }
}

/// Checks the `size` and number of samples of a frame against its file's header.
///
/// # Errors
/// Others.
fn check(size: [usize; 2], samples: usize, format: &PixelFormat) -> Result<(), String> {
    if (size, samples) == (format.size, format.samples) {
        return Ok(());
    }
    let ([x, y], [nx, ny]) = (size, format.size);
    Err(format!(
        "its compressed pixels are {x}x{y} of {samples} samples, but its header says {nx}x{ny} of {}; ask for another copy",
        format.samples
    ))
}
