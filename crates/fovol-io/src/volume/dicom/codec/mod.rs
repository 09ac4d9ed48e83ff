//! Codecs of single frames.

mod decoded;
mod jpeg;
mod jpeg2000;
mod jpeg_ls;
mod rle;

use super::pixel_format::PixelFormat;
use super::syntax::Codec;
pub use decoded::Decoded;

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
