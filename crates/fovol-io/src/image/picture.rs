use fovol_core::{Frame, FrameSize};

/// An image read from a file.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    /// Its pixels; alpha is 1 where the file has none.
    pub frame: Frame,
    /// Whether the file has alpha.
    pub has_alpha: bool,
    /// Assumptions made while reading, one line each.
    pub notes: Vec<String>,
}

/// Motion vectors of a frame, read from a file.
#[derive(Debug, Clone, PartialEq)]
pub struct Motion {
    /// The size of the frame.
    pub size: FrameSize,
    /// Per pixel, row by row, the offset to its position in the previous frame: right and down, in pixels.
    pub ways: Vec<[f32; 2]>,
    /// Assumptions made while reading, one line each.
    pub notes: Vec<String>,
}
