use crate::Timings;
use std::fmt;

/// A part of reconstruction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// Where every pixel was in the last frame.
    Motion,
    /// The full frame.
    Filling,
}

impl Part {
    /// How many there are.
    pub const COUNT: u32 = 2;

    /// Adds what this took to what is known of the frame.
    pub fn add(self, timings: &mut Timings, ms: f64) {
        timings.reconstruct += ms;
        if self == Self::Motion {
            timings.motion += ms;
        }
    }
}

impl fmt::Display for Part {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Motion => "motion",
            Self::Filling => "filling",
        })
    }
}
