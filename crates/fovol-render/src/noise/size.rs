/// The size of a volume of noise: pixels along x and y, frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NoiseSize {
    /// Pixels along x, 16…256.
    pub width: usize,
    /// Pixels along y, 16…256.
    pub height: usize,
    /// Frames, 1…256; one frame is plain blue noise.
    pub frames: usize,
}

impl NoiseSize {
    /// The paper's tile: 128×128 pixels, 64 frames.
    pub const STBN: Self = Self { width: 128, height: 128, frames: 64 };

    /// A size within the limits.
    ///
    /// # Errors
    /// A side outside 16…256 or a number of frames outside 1…256.
    pub fn new(width: usize, height: usize, frames: usize) -> Result<Self, String> {
        let side = 16..=256;
        if side.contains(&width) && side.contains(&height) && (1..=256).contains(&frames) {
            Ok(Self { width, height, frames })
        } else {
            Err(format!(
                "noise of {width}x{height}x{frames} is out of reach; use 16 to 256 pixels a side and 1 to 256 frames"
            ))
        }
    }

    /// The number of ranks.
    pub fn len(self) -> usize {
        self.frame_len() * self.frames
    }

    /// The number of ranks of one frame.
    pub fn frame_len(self) -> usize {
        self.width * self.height
    }

    /// Never: sizes have at least one rank.
    pub fn is_empty(self) -> bool {
        self.len() == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_have_limits() {
        assert!(NoiseSize::new(15, 16, 1).is_err() && NoiseSize::new(16, 257, 1).is_err());
        assert!(NoiseSize::new(16, 16, 0).is_err() && NoiseSize::new(16, 16, 257).is_err());
        assert_eq!(NoiseSize::new(128, 128, 64), Ok(NoiseSize::STBN));
    }
}
