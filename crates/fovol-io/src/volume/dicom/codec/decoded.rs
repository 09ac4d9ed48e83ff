//! Samples of one frame, and their check.

use crate::volume::dicom::pixel_format::PixelFormat;

/// Samples of one frame.
pub struct Decoded {
    /// Little-endian samples of the format's size, interleaved.
    pub bytes: Vec<u8>,
    /// Whether colours are red, green and blue by now.
    pub is_rgb: bool,
}

/// Checks the `size` and number of samples of a frame against its file's header.
///
/// # Errors
/// Others.
pub fn check(size: [usize; 2], samples: usize, format: &PixelFormat) -> Result<(), String> {
    if (size, samples) == (format.size, format.samples) {
        return Ok(());
    }
    let ([x, y], [nx, ny]) = (size, format.size);
    Err(format!(
        "its compressed pixels are {x}x{y} of {samples} samples, but its header says {nx}x{ny} of {}; ask for another copy",
        format.samples
    ))
}
