use crate::Timings;
use std::fmt;

/// Timed part of the reconstruction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// Estimation of motion.
    Motion,
    /// Filling of the full frame.
    Filling,
}

impl Part {
    /// Number of parts.
    pub const COUNT: u32 = 2;

    /// Adds `ms` for this part to `timings`.
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
