use crate::Timings;
use fovol_render::gpu::Stage;
use std::fmt;

/// Timed part of a frame after its samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// Marching of the guide.
    Guide,
    /// Estimation of motion.
    Motion,
    /// Filling of the full frame.
    Filling,
}

impl Part {
    /// Number of parts.
    pub const COUNT: u32 = 3;

    /// Adds `ms` for this part to `timings`.
    pub fn add(self, timings: &mut Timings, ms: f64) {
        match self {
            Self::Guide => timings.guide += ms,
            Self::Motion => {
                timings.reconstruct += ms;
                timings.motion += ms;
            }
            Self::Filling => timings.reconstruct += ms,
        }
    }
}

impl fmt::Display for Part {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Guide => "guide",
            Self::Motion => "motion",
            Self::Filling => "filling",
        })
    }
}

/// Adds the time of `stage` to `timings`.
pub fn add_stage(timings: &mut Timings, stage: Stage, ms: f64) {
    match stage {
        Stage::Mask => timings.mask += ms,
        Stage::Compact => {
            timings.mask += ms;
            timings.compact += ms;
        }
        Stage::March => timings.march += ms,
        Stage::Scatter => {
            timings.march += ms;
            timings.scatter += ms;
        }
    }
}
