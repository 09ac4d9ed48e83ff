//! Parts that both visible difference predictors share: the display, the pyramid, the memory of temporal filters.

mod display;
mod display_names;
pub(crate) mod history;
pub(crate) mod log_math;
pub(crate) mod pyramid;

pub use display::Display;
pub(crate) use display::linearise;
pub(crate) use display_names::NAMES as DISPLAY_NAMES;
pub use pyramid::MIN_SIDE;

use crate::{Error, Result};

/// Highest frame rate in frames a second, since a quarter second of frames is kept in memory.
pub const MAX_FPS: f64 = 1000.0;

/// Checks that `fps` is above 0 and at most [`MAX_FPS`], and returns it.
pub(crate) fn check_rate(fps: f64) -> Result<f64> {
    if fps > 0.0 && fps <= MAX_FPS { Ok(fps) } else { Err(Error::FrameRate { found: fps.to_string() }) }
}
