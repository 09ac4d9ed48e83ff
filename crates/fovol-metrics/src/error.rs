use crate::Display;
use fovol_core::{Frame, FrameSize};

/// Why two frames cannot be compared.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The frames differ in size.
    #[error("the frames differ in size: {reference} and {test}; render or scale both to one size")]
    SizesDiffer {
        /// The size of the reference.
        reference: FrameSize,
        /// The size of the frame that is measured.
        test: FrameSize,
    },
    /// A frame is smaller than the measure's window.
    #[error(
        "{measure} needs frames of at least {needed}x{needed} pixels, these are {found}; use larger frames"
    )]
    TooSmall {
        /// The measure's name.
        measure: &'static str,
        /// Pixels needed along each side.
        needed: u32,
        /// The size found.
        found: FrameSize,
    },
    /// A frame differs in size from those before it.
    #[error("a frame of {now} follows frames of {before}; give frames of one size")]
    SizeChanged {
        /// The size of the frames before.
        before: FrameSize,
        /// The size of this frame.
        now: FrameSize,
    },
    /// No display has this name.
    #[error("there is no display `{name}`; use one of {}", Display::NAMES.join(", "))]
    UnknownDisplay {
        /// The name asked for.
        name: String,
    },
    /// A display that nobody can see a picture on.
    #[error(
        "the display cannot be: sizes, distance and peak must be above 0, contrast at least 1, ambient light \
         not negative, reflectivity 0 to 1, and black darker than white"
    )]
    ImpossibleDisplay,
    /// Frames that do not follow each other in time.
    #[error("{found} frames a second are no frame rate; give a number above 0, at most 1000")]
    FrameRate {
        /// The rate.
        found: String,
    },
    /// A gaze that is nowhere.
    #[error("the gaze {found} is no point; give two finite numbers")]
    Gaze {
        /// Its coordinates.
        found: String,
    },
}

/// The result of the operations of this crate.
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
