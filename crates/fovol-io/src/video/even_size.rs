use fovol_core::FrameSize;

/// `size` with even sides, which clips with chroma at half resolution need: one more pixel along each odd side.
pub fn padded_to_even(size: FrameSize) -> FrameSize {
    // The largest side of a frame is even.
    FrameSize { width: size.width.next_multiple_of(2), height: size.height.next_multiple_of(2) }
}
