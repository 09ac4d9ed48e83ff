use crate::vdp::DISPLAY_NAMES;
use fovol_core::{Frame, FrameSize};

/// Reasons why frames cannot be compared.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The frames differ in size.
    #[error("the frames differ in size: {reference} and {test}; render or scale both to one size")]
    SizesDiffer {
        /// Size of the reference.
        reference: FrameSize,
        /// Size of the measured frame.
        test: FrameSize,
    },
    /// The frame is smaller than the metric's window.
    #[error(
        "{measure} needs frames of at least {needed}x{needed} pixels, these are {found}; use larger frames"
    )]
    TooSmall {
        /// Name of the metric.
        measure: &'static str,
        /// Smallest side in pixels.
        needed: u32,
        /// Size of the frame.
        found: FrameSize,
    },
    /// The frame differs in size from earlier frames.
    #[error("a frame of {now} follows frames of {before}; give frames of one size")]
    SizeChanged {
        /// Size of earlier frames.
        before: FrameSize,
        /// Size of this frame.
        now: FrameSize,
    },
    /// No display has this name.
    #[error("there is no display `{name}`; use one of {}", DISPLAY_NAMES.join(", "))]
    UnknownDisplay {
        /// The requested name.
        name: String,
    },
    /// The display parameters are impossible.
    #[error(
        "the display cannot be: sizes, distance and peak must be above 0, contrast at least 1, ambient light \
         not negative, reflectivity 0 to 1, and black darker than white"
    )]
    ImpossibleDisplay,
    /// The frame rate is not positive or too large.
    #[error("{found} frames a second are no frame rate; give a number above 0, at most 1000")]
    FrameRate {
        /// The rate.
        found: String,
    },
    /// The gaze is not finite.
    #[error("the gaze {found} is no point; give two finite numbers")]
    Gaze {
        /// Its coordinates.
        found: String,
    },
}

/// Result with the errors of this crate.
pub type Result<T> = std::result::Result<T, Error>;

pub(crate) fn same_size(reference: &Frame, test: &Frame) -> Result<FrameSize> {
    let (a, b) = (reference.size(), test.size());
    if a == b { Ok(a) } else { Err(Error::SizesDiffer { reference: a, test: b }) }
}

pub(crate) fn at_least(measure: &'static str, needed: u32, found: FrameSize) -> Result<()> {
    if found.width.min(found.height) >= needed {
        Ok(())
    } else {
        Err(Error::TooSmall { measure, needed, found })
    }
}
