//! Calls of convolution kernels.

/// Arguments of a kernel, for a group of neighbouring pixels of one patch. Lengths are in 32-bit words.
#[derive(Debug, Clone, Copy)]
pub struct Call {
    /// First word of the first window.
    pub patch: *const u32,
    /// Distance between rows of the patch.
    pub row: usize,
    /// Distance between the windows of neighbouring pixels.
    pub pixel: usize,
    /// Rows of a window.
    pub rows: usize,
    /// Words of a window's row, which are contiguous.
    pub run: usize,
    /// Weights of a block: \[row\]\[word of the run\]\[channel of the block\].
    pub weights: *const u32,
    /// Initial value of sums, for each channel of the block. Sums of bytes start from zero.
    pub bias: *const f32,
}

/// A kernel: computes the sums of a call, and writes pixels × block width to its second argument, pixel by pixel.
/// Sums are 32-bit integers for int8, else f32.
pub type Kernel = unsafe fn(call: &Call, out: *mut f32);
